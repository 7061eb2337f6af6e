# SPDX-License-Identifier: Apache-2.0
#   docker build -t quench .
#   docker run --rm -v "$PWD:/data" --user "$(id -u):$(id -g)" quench run shape.ply -o out
FROM debian:12 AS build
WORKDIR /quench
COPY scripts/install-deps scripts/
# make-packages asks the program file which files have libraries that a package depends on.
RUN scripts/install-deps --build && apt-get install -y -qq --no-install-recommends file
COPY . .
RUN cmake --preset release -DQUENCH_TESTS=OFF -DQUENCH_BENCH=OFF -DQUENCH_PYTHON=OFF && \
    cmake --build build/release --target quench quench_program && \
    scripts/make-packages build/release

FROM debian:12-slim
LABEL org.opencontainers.image.title="Quench" \
      org.opencontainers.image.version="0.1.0" \
      org.opencontainers.image.licenses="Apache-2.0"
COPY --from=build /quench/build/release/packages/quench_*.deb /tmp/
RUN apt-get update && \
    apt-get install -y --no-install-recommends /tmp/quench_*.deb && \
    rm -rf /var/lib/apt/lists/* /tmp/quench_*.deb
WORKDIR /data
ENTRYPOINT ["quench"]
CMD ["--help"]
