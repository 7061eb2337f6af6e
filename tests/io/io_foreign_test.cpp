// SPDX-License-Identifier: Apache-2.0
// Damaged files of the formats that Assimp reads: whatever the library does on them (exceptions, crashes,
// endless reading), reading gives valid data or one sentence.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <functional>
#include <iterator>
#include <memory>
#include <random>
#include <thread>

#include "base/platform/child_process.h"
#include "data.h"
#include "poly_samples.h"
#include "quench/shape.h"
#ifdef QUENCH_TESTS_HAVE_ASSIMP
#include <assimp/mesh.h>
#include <assimp/scene.h>

#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#endif

namespace quench {
namespace io_foreign_test {

using testing_files::Folder;
using testing_files::write_bytes;

struct Damage {
  std::string bytes, how;
};

/// Truncations and changed bytes, a fixed choice of at most about `most`.
std::vector<Damage> damages(const std::string& valid, std::size_t most) {
  std::vector<Damage> list;
  const std::size_t stride = std::max<std::size_t>(1, 3 * valid.size() / most);
  for (std::size_t size = 0; size < valid.size(); size += stride)
    list.push_back({valid.substr(0, size), "cut to " + std::to_string(size)});
  std::mt19937 random(3);
  const int values[] = {0, 255, 128, 1, 127, '9', '-', ' ', '\n'};
  while (list.size() < most && !valid.empty()) {
    Damage damage{valid, "changed"};
    for (int edits = 1 + static_cast<int>(random() % 2); edits > 0; --edits) {
      const std::size_t at = random() % valid.size();
      const int value = random() % 4 == 0 ? damage.bytes[at] ^ 1 << random() % 8 : values[random() % std::size(values)];
      damage.bytes[at] = static_cast<char>(value);
      damage.how += " " + std::to_string(at) + " to " + std::to_string(value & 255);
    }
    list.push_back(std::move(damage));
  }
  return list;
}

/// Nothing when `action` succeeds or says one sentence, else what is wrong.
std::string complaint(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    const std::string sentence = error.what();
    const bool memory = error.code() == ErrorCode::failed && sentence.find("memory") != sentence.npos;
    if ((error.code() == ErrorCode::input || memory) && !sentence.empty() && sentence.find('\n') == sentence.npos)
      return {};
    return "not one sentence about the input: " + sentence;
  } catch (const std::exception& error) {
    return std::string("another exception: ") + error.what();
  }
  return {};
}

#ifdef QUENCH_TESTS_HAVE_ASSIMP
/// A box as bytes of a format that Assimp writes.
std::string exported(const std::string& format) {
  const Folder folder;
  write_bytes(folder / "box.off",
              "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n"
              "4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n");
  Assimp::Importer importer;
  if (!importer.ReadFile((folder / "box.off").string(), 0)) return {};
  // The exporter of 3MF leaves out the meshes of the root: give them to a child of it.
  const std::unique_ptr<aiScene> scene(importer.GetOrphanedScene());
  auto* root = new aiNode("root");
  root->addChildren(1, &scene->mRootNode);
  scene->mRootNode = root;
  Assimp::Exporter exporter;
  const std::string path = (folder / "out.bin").string();
  if (exporter.Export(scene.get(), format, path) != AI_SUCCESS) return {};
  return testing_files::bytes_of(path);
}

std::vector<std::pair<std::string, std::string>> meshes() {
  std::vector<std::pair<std::string, std::string>> list{
      {"a.ac",
       "AC3Db\nMATERIAL \"m\" rgb 1 1 1 amb 0 0 0 emis 0 0 0 spec 0 0 0 shi 0 trans 0\nOBJECT world\nkids 1\nOBJECT "
       "poly\nnumvert 3\n0 0 0\n1 0 0\n0 1 0\nnumsurf 1\nSURF 0x20\nmat 0\nrefs 3\n0 0 0\n1 0 0\n2 0 0\nkids 0\n"},
      {"a.nff", "pp 3\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\np 3\n0 0 0\n1 0 0\n0 1 0\n"},
      {"a.smd",
       "version 1\nnodes\n0 \"r\" -1\nend\nskeleton\ntime 0\n0 0 0 0 0 0 0\nend\ntriangles\nm\n0 0 0 0 0 0 1 0 0\n"
       "0 1 0 0 0 0 1 0 0\n0 0 1 0 0 0 1 0 0\nend\n"},
      {"a.dxf",
       "0\nSECTION\n2\nENTITIES\n0\n3DFACE\n8\n0\n10\n0\n20\n0\n30\n0\n11\n1\n21\n0\n31\n0\n12\n0\n22\n1\n32\n0\n13\n"
       "0\n23\n1\n33\n0\n0\nENDSEC\n0\nEOF\n"},
  };
  for (const auto& [name, format] : std::initializer_list<std::pair<const char*, const char*>>{{"a.dae", "collada"},
                                                                                               {"a.x", "x"},
                                                                                               {"a.3ds", "3ds"},
                                                                                               {"a.gltf", "gltf2"},
                                                                                               {"a.glb", "glb2"},
                                                                                               {"b.glb", "glb"},
                                                                                               {"b.fbx", "fbx"},
                                                                                               {"a.fbx", "fbxa"},
                                                                                               {"a.3mf", "3mf"}})
    if (std::string bytes = exported(format); !bytes.empty()) list.emplace_back(name, std::move(bytes));
  return list;
}
#endif

TEST(Foreign, DamagedMeshes) {
#ifndef QUENCH_TESTS_HAVE_ASSIMP
  GTEST_SKIP() << "built without Assimp";
#else
  const Folder folder;
  std::size_t readable = 0;
  bool has_3mf = false, readable_3mf = false;
  for (const auto& [name, valid] : meshes()) {
    has_3mf = has_3mf || name.ends_with(".3mf");
    const auto path = folder / name;
    const auto read = [&] { io::read_record(path).validate(); };
    write_bytes(path, valid);
    try {
      read();
      ++readable;
      readable_3mf = readable_3mf || name.ends_with(".3mf");
    } catch (const Error&) {  // some builds of Assimp lack a format, or keep its buffers in a second file
    }
    for (const Damage& damage : damages(valid, 15)) {
      write_bytes(path, damage.bytes);
      const std::string wrong = complaint(read);
      if (!wrong.empty()) ADD_FAILURE() << name << ", " << damage.how << ": " << wrong;
    }
  }
  EXPECT_GE(readable, 8u);
  EXPECT_EQ(has_3mf, readable_3mf);
#endif
}

TEST(Apart, WhateverALibraryDoesIsOneSentence) {
  const Folder folder;
  write_bytes(folder / "a.bin", "bytes");
  const auto path = folder / "a.bin";
  const base::SandboxLimits little{.seconds = 0.5, .bytes = 1 << 26};
  const auto refused = [&](const std::function<std::string()>& read) {
    std::string sentence;
    EXPECT_EQ(testing_files::code_of([&] { base::read_in_child_process(path, read, little); }, &sentence),
              ErrorCode::input);
    EXPECT_NE(sentence.find("a.bin"), std::string::npos) << sentence;
    return sentence;
  };
  EXPECT_EQ(base::read_in_child_process(path, [] { return std::string(1 << 20, 'x'); }), std::string(1 << 20, 'x'));
  EXPECT_EQ(base::read_in_child_process(path, [] { return std::string(); }), "");
  EXPECT_NE(refused([]() -> std::string {
              raise(SIGSEGV);
              return {};
            }).find("fails"),
            std::string::npos);
  EXPECT_NE(refused([]() -> std::string { std::abort(); }).find("fails"), std::string::npos);
  EXPECT_NE(refused([]() -> std::string { _exit(0); }).find("fails"), std::string::npos);
  EXPECT_NE(refused([]() -> std::string {
              for (volatile bool forever = true; forever;) {
              }
              return {};
            }).find("takes too long"),
            std::string::npos);
  EXPECT_NE(refused([]() -> std::string { throw Error(ErrorCode::input, "a.bin is odd"); }).find("odd"),
            std::string::npos);
  EXPECT_NE(refused([]() -> std::string { throw std::runtime_error("odder"); }).find("fails"), std::string::npos);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_NE(refused([]() -> std::string {
              volatile std::size_t size = std::size_t{1} << 32;  // else Clang 14 makes the string itself, and crashes
              return std::string(size, 'x');
            }).find("memory"),
            std::string::npos);
#endif
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
}

TEST(Apart, FromSeveralThreads) {
  const Folder folder;
  write_bytes(folder / "a.bin", "bytes");
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 10; ++i) {
        const std::string bytes(1000 + static_cast<std::size_t>(t), static_cast<char>('a' + t));
        EXPECT_EQ(base::read_in_child_process(folder / "a.bin", [&] { return bytes; }), bytes);
      }
    });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace io_foreign_test
}  // namespace quench
