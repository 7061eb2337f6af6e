# SPDX-License-Identifier: Apache-2.0
# frozen_string_literal: true

# Formula of Homebrew on Linux. A release fills in homepage, url and sha256: there is no public one yet.
class Quench < Formula
  desc "Medial axes and skeletons of 3D shapes, exact on voxels"
  homepage "https://quench.invalid"
  url "https://quench.invalid/releases/quench-0.1.0.tar.gz"
  version "0.1.0"
  sha256 "0000000000000000000000000000000000000000000000000000000000000000"
  license "Apache-2.0"

  depends_on "cli11" => :build
  depends_on "cmake" => :build
  depends_on "ninja" => :build
  depends_on "nlohmann-json" => :build
  depends_on "node" => :build
  depends_on "assimp"
  depends_on "c-blosc"
  depends_on "eigen"
  depends_on "fmt"
  depends_on "freetype"
  depends_on "gdcm"
  depends_on "hdf5"
  depends_on "jpeg-turbo"
  depends_on "libtiff"
  depends_on :linux # docs/user/install.md says what stands in the way of macOS
  depends_on "pugixml"
  depends_on "tbb"
  depends_on "zlib"
  depends_on "zstd"

  # The letters of pictures are built in.
  resource "dejavu" do
    url "https://github.com/dejavu-fonts/dejavu-fonts/releases/download/version_2_37/dejavu-fonts-ttf-2.37.tar.bz2"
    sha256 "fa9ca4d13871dd122f61258a80d01751d603b4d3ee14095d65453b4e846e17d7"
  end

  def install
    (buildpath/"dejavu").install resource("dejavu")
    args = %W[
      -DQUENCH_TESTS=OFF
      -DQUENCH_BENCH=OFF
      -DQUENCH_PYTHON=OFF
      -DQUENCH_WERROR=OFF
      -DQUENCH_FONT=#{buildpath}/dejavu/ttf/DejaVuSans.ttf
    ]
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", *args, *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    system bin/"quench", "sample", "torus", "-o", "torus.ply"
    system bin/"quench", "run", "torus.ply", "--resolution", "64", "-o", "torus"
    assert_path_exists testpath/"torus/core.vtp"
    system bin/"quench", "verify", "torus.ply", "torus/core.vtp"
  end
end
