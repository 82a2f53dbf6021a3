"""What every test may rely on: one thread a process, as in the service, set before NumPy starts its pool."""

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"
