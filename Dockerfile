FROM debian:12-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends python3.11 python3-venv bubblewrap util-linux gcc g++ libc6-dev octave \
       libeigen3-dev libopencv-core-dev libopencv-imgproc-dev libopencv-video-dev \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /srv/seamark
COPY pyproject.toml uv.lock LICENSE README.md ./
RUN python3.11 -m venv /opt/uv && /opt/uv/bin/pip install -q uv==0.13.8 \
    && /opt/uv/bin/uv sync --frozen --no-dev --extra server --no-install-project --python /usr/bin/python3.11
COPY . .
RUN /opt/uv/bin/uv sync --frozen --no-dev --extra server --python /usr/bin/python3.11
ENV PATH=/srv/seamark/.venv/bin:$PATH
RUN python -c 'from seamark.sim.engine.warm_up import warm_up; warm_up()'
