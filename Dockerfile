# primfit as a service: docker build --tag primfit . && docker run --rm --publish 8000:8000 primfit
# Any base with python3 (3.11 or newer, with venv) and apt-get will do; both stages must have the same one.
ARG BASE_IMAGE=python:3.11-slim

FROM ${BASE_IMAGE} AS build
ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore
WORKDIR /src
# A compiler for the inner loops of the search and, where the base brings none, the headers of its Python.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends gcc libc6-dev \
    && if ! test -e "$(python3 -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h"; then \
           apt-get install --yes --no-install-recommends python3-dev; \
       fi \
    && rm -rf /var/lib/apt/lists/*
RUN python3 -m venv /opt/primfit
# What it needs, in a layer of its own: only a change of pyproject.toml builds it again.
COPY pyproject.toml ./
RUN python3 -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['project']['dependencies'], sep='\n')" \
        > requirements.txt \
    && /opt/primfit/bin/pip install --requirement requirements.txt \
    && rm -rf /opt/primfit/lib/python3*/site-packages/scipy/*/tests \
              /opt/primfit/lib/python3*/site-packages/scipy/*/*/tests \
              /opt/primfit/lib/python3*/site-packages/sklearn/tests \
              /opt/primfit/lib/python3*/site-packages/sklearn/*/tests
COPY . ./
RUN /opt/primfit/bin/pip install --no-deps . \
    && /opt/primfit/bin/pip uninstall --yes pip setuptools

FROM ${BASE_IMAGE}
LABEL org.opencontainers.image.title="primfit" \
      org.opencontainers.image.description="Which geometric primitive is this 3D point cloud, and with which parameters?" \
      org.opencontainers.image.licenses="Apache-2.0"
COPY --from=build /opt/primfit /opt/primfit
# One thread a process: the worker processes share the cores among them.
ENV PATH=/opt/primfit/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    OMP_NUM_THREADS=1 \
    OPENBLAS_NUM_THREADS=1 \
    PRIMFIT_HOST=0.0.0.0 \
    PRIMFIT_PORT=8000
USER 10001:10001
WORKDIR /tmp
EXPOSE 8000
HEALTHCHECK --interval=30s --timeout=5s --start-period=30s --retries=3 \
    CMD ["python3", "-c", "import os, urllib.request; urllib.request.urlopen('http://127.0.0.1:' + os.environ['PRIMFIT_PORT'] + '/readyz', timeout=4)"]
ENTRYPOINT ["primfit"]
CMD ["serve"]
