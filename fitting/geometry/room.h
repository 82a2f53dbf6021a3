/* Room for numbers; free() gives it back. */
#pragma once

#include <Python.h>
#include <stdlib.h>

/* Of one number more than asked for, so that there is always some; null, with MemoryError set, where there is none. */
static inline double *room_for(Py_ssize_t numbers)
{
    double *room = malloc((size_t)(numbers + 1) * sizeof *room);
    if (!room)
        PyErr_NoMemory();
    return room;
}
