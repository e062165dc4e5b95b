# Two images of one build: `web`, and `worker` with what the languages of programs need.
#   docker build --target web --tag seamark-web .
#   docker build --target worker --tag seamark-worker .
# Everything comes from Debian and from the packages in uv.lock, whose hashes uv checks.
ARG DEBIAN=debian:12-slim

FROM ${DEBIAN} AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends python3.11 python3-venv \
    && rm -rf /var/lib/apt/lists/*
RUN python3.11 -m venv /opt/uv && /opt/uv/bin/pip install --quiet --no-cache-dir uv==0.13.8
ENV UV_PROJECT_ENVIRONMENT=/opt/seamark UV_COMPILE_BYTECODE=1 UV_NO_CACHE=1 \
    UV_PYTHON=/usr/bin/python3.11 UV_PYTHON_DOWNLOADS=never
WORKDIR /src
COPY pyproject.toml uv.lock ./
COPY deploy/client/pyproject.toml deploy/client/
RUN /opt/uv/bin/uv sync --frozen --no-dev --extra server --extra pybullet --no-install-workspace
COPY . .
RUN /opt/uv/bin/uv sync --frozen --no-dev --extra server --extra pybullet --no-editable
# For the processor of the machine that builds; on another one a worker compiles at its first start.
RUN NUMBA_CACHE_DIR=/var/cache/seamark-code /opt/seamark/bin/python -c \
    'from seamark.sim.engine.warm_up import warm_up; warm_up()'

FROM ${DEBIAN} AS web
ARG VERSION=0.1.0
LABEL org.opencontainers.image.title="Seamark" \
      org.opencontainers.image.description="Online benchmark for underwater intervention robots" \
      org.opencontainers.image.licenses="Apache-2.0" \
      org.opencontainers.image.version="${VERSION}"
RUN apt-get update \
    && apt-get install -y --no-install-recommends python3.11 \
    && rm -rf /var/lib/apt/lists/* \
    && groupadd --system --gid 10001 seamark \
    && useradd --system --uid 10001 --gid 10001 --home-dir /nonexistent --shell /usr/sbin/nologin seamark \
    && install -d -m 0770 -o root -g seamark /data
COPY --from=build /opt/seamark /opt/seamark
# Writable by the group of the web's user and by root, who needs no further right for that.
COPY --from=build --chown=root:seamark --chmod=0775 /var/cache/seamark-code /var/cache/seamark-code
ENV PATH=/opt/seamark/bin:/usr/bin:/bin SEAMARK_DATA=/data NUMBA_CACHE_DIR=/var/cache/seamark-code \
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 PYTHONUNBUFFERED=1
USER 10001:10001
EXPOSE 8000
HEALTHCHECK --interval=30s --timeout=10s --start-period=60s \
    CMD ["python", "-c", "import urllib.request as r; r.urlopen('http://127.0.0.1:8000/readyz', timeout=8)"]
CMD ["seamark", "web", "--host", "0.0.0.0"]

FROM web AS worker
USER root
RUN apt-get update \
    && apt-get install -y --no-install-recommends bubblewrap gcc g++ libc6-dev octave \
       libeigen3-dev libopencv-core-dev libopencv-imgproc-dev libopencv-video-dev \
    && rm -rf /var/lib/apt/lists/*
# As a plain user the sandbox reaches `medium`; compose.yaml and docs/hosting.md say what `strong` needs.
USER 10001:10001
HEALTHCHECK --interval=60s --timeout=20s --start-period=300s CMD ["seamark", "worker", "--ping"]
CMD ["seamark", "worker"]
