# SPDX-License-Identifier: Apache-2.0
# The program, the library and the Python module: callPackage this file. nixpkgs 25.05 or newer. Without interactive pages of results:
# viewer/package-lock.json names no addresses of the packages they are built with, and a build in Nix has no network.
{
  lib,
  stdenv,
  cmake,
  ninja,
  pkg-config,
  python3,
  tbb_2022,
  eigen,
  fmt,
  cli11,
  nlohmann_json,
  pugixml,
  zlib,
  freetype,
  dejavu_fonts,
  libtiff,
  libjpeg,
  assimp,
  zstd,
  c-blosc,
  hdf5,
  gdcm,
}:

stdenv.mkDerivation {
  pname = "quench";
  version = "0.1.0";
  src = lib.cleanSource ../..;

  nativeBuildInputs = [
    cmake
    ninja
    pkg-config
  ];
  buildInputs = [
    cli11
    nlohmann_json
    (python3.withPackages (p: [ p.numpy p.pybind11 ]))
  ];
  # Who links the static library needs them, too.
  propagatedBuildInputs = [
    tbb_2022
    eigen
    fmt
    pugixml
    zlib
    freetype
    libtiff
    libjpeg
    assimp
    zstd
    c-blosc
    hdf5
    gdcm
  ];

  cmakeFlags = [
    (lib.cmakeBool "QUENCH_TESTS" false)
    (lib.cmakeBool "QUENCH_BENCH" false)
    (lib.cmakeBool "QUENCH_WERROR" false)
    (lib.cmakeBool "QUENCH_VIEWER" false)
    (lib.cmakeFeature "QUENCH_PYTHON" "ON")
    (lib.cmakeFeature "QUENCH_PYTHON_DIR" "${python3.sitePackages}")
    (lib.cmakeFeature "QUENCH_FONT" "${dejavu_fonts}/share/fonts/truetype/DejaVuSans.ttf")
  ];
  postInstall = ''
    cmake --install . --component python
  '';

  doInstallCheck = true;
  installCheckPhase = ''
    $out/bin/quench sample torus -o torus.ply
    $out/bin/quench run torus.ply --resolution 64 -o torus
    $out/bin/quench verify torus.ply torus/core.vtp
  '';

  meta = {
    description = "Medial axes and skeletons of 3D shapes, exact on voxels";
    license = lib.licenses.asl20;
    mainProgram = "quench";
    platforms = [ "x86_64-linux" "aarch64-linux" ];
  };
}
