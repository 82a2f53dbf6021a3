/* The kinds that the compiled loops know, in the order of their numbers, and the distances of any of them. */
#pragma once

#include "primitives/plane.h"
#include "primitives/sphere.h"
#include "primitives/cylinder.h"
#include "primitives/cone.h"
#include "primitives/torus.h"

static const Kind KINDS[] = {PLANE_KIND, SPHERE_KIND, CYLINDER_KIND, CONE_KIND, TORUS_KIND};
static const int COUNT = sizeof KINDS / sizeof *KINDS;

static inline void multiply(double *restrict values, const double *restrict factor, ptrdiff_t n)
{
    for (ptrdiff_t i = 0; i < n; i++)
        values[i] *= factor[i];
}

/* Distances d (n) and, unless that pointer is null, derivatives j (dof, n); both times the factors. */
static inline void linearize(const Surface *s, Points points, double *d, double *j)
{
    const Kind *kind = &KINDS[s->kind];
    if (j)
        kind->slopes(s, points, d, j);
    else
        kind->distances(s, points, d);
    if (!points.factor)
        return;
    multiply(d, points.factor, points.n);
    for (int row = 0; j && row < kind->dof; row++)
        multiply(j + row * points.n, points.factor, points.n);
}
