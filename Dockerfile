# primfit as a service: docker build --tag primfit . && docker run --rm --publish 8000:8000 primfit
# With every extra that a user may want: docker build --target full --tag primfit:full .
# Any base with python3 (3.11 or newer, with venv) and apt-get will do; all stages have the same one. A name with a
# digest (python@sha256:...) pins it: docs/docker.md.
ARG BASE_IMAGE=python:3.11-slim

FROM ${BASE_IMAGE} AS build
ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore
WORKDIR /src
# A compiler for the inner loops of the search and, where the base brings none, the headers of its Python.
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends gcc libc6-dev \
    && if ! test -e "$(python3 -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h"; then \
           apt-get install --yes --no-install-recommends python3-dev; \
       fi \
    && rm -rf /var/lib/apt/lists/*
# What is in the image has no pip of its own: one beside it installs, and builds.
COPY requirements/build.txt requirements/image.txt requirements/
RUN python3 -m venv /opt/pip && python3 -m venv --without-pip /opt/primfit \
    && /opt/pip/bin/pip install --require-hashes --requirement requirements/build.txt
# What it needs, in a layer of its own: only a change of the lock builds it again. The tests that packages bring
# are left out, but for those of numpy._core, which numpy.testing imports.
RUN /opt/pip/bin/pip --python /opt/primfit/bin/python install --require-hashes --requirement requirements/image.txt \
    && find /opt/primfit -type d -name tests ! -path '*/numpy/_core/*' -prune -exec rm -rf {} +
COPY . ./
RUN /opt/pip/bin/pip wheel --no-deps --no-build-isolation --wheel-dir /wheels . \
    && /opt/pip/bin/pip --python /opt/primfit/bin/python install --no-deps --no-index /wheels/*.whl

# The extras, but neither the tools of development nor torch, which the service never imports.
FROM build AS build-full
RUN /opt/pip/bin/pip --python /opt/primfit/bin/python install --require-hashes --requirement requirements/full.txt \
    && find /opt/primfit -type d -name tests ! -path '*/numpy/_core/*' -prune -exec rm -rf {} +

FROM ${BASE_IMAGE} AS runtime
LABEL org.opencontainers.image.title="primfit" \
      org.opencontainers.image.description="Which geometric primitive is this 3D point cloud, and with which parameters?" \
      org.opencontainers.image.licenses="Apache-2.0"
# One thread a process: the worker processes share the cores among them.
ENV PATH=/opt/primfit/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    OMP_NUM_THREADS=1 \
    OPENBLAS_NUM_THREADS=1 \
    PRIMFIT_HOST=0.0.0.0 \
    PRIMFIT_PORT=8000
# For jobs, where PRIMFIT_JOBS_PATH names it: a volume that is mounted here belongs to the user, too.
RUN install --directory --owner 10001 --group 10001 --mode 700 /var/lib/primfit
USER 10001:10001
WORKDIR /tmp
EXPOSE 8000
# The service stops listening, finishes what is under way, and ends with status 0.
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=30s --timeout=5s --start-period=30s --retries=3 \
    CMD ["python3", "-c", "import os, urllib.request; urllib.request.urlopen('http://127.0.0.1:' + os.environ['PRIMFIT_PORT'] + '/readyz', timeout=4)"]
ENTRYPOINT ["primfit"]
CMD ["serve"]

FROM runtime AS full
# matplotlib keeps its list of fonts here.
ENV MPLCONFIGDIR=/tmp/matplotlib
COPY --from=build-full /opt/primfit /opt/primfit

# The last stage is what is built without --target.
FROM runtime
COPY --from=build /opt/primfit /opt/primfit
