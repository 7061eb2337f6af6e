// SPDX-License-Identifier: Apache-2.0
#include <poll.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <sstream>

#include "program.h"

// `quench batch`: one folder per sample and the tables of all, whatever happens on the way.

using namespace quench::testing_program;
namespace fs = std::filesystem;

namespace program_batch_test {

class Batch : public ProgramTest {
 protected:
  using Words = std::vector<std::string>;

  /// `quench batch arguments... -- run` of small shapes, without pages.
  static Words line(const Words& arguments, const Words& options = {}) {
    Words words{"batch"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    words.insert(words.end(), {"--", "run", "--resolution", "8", "--no-view", "--no-picture"});
    words.insert(words.end(), options.begin(), options.end());
    return words;
  }
  Outcome batch(int code, const Words& arguments, const Words& options = {}) {
    const Outcome outcome = quench(line(arguments, options));
    EXPECT_EQ(outcome.code, code) << testing::PrintToString(arguments) << '\n' << outcome.err;
    return outcome;
  }

  /// Rows of a table, whose cells must not hold quotes or line ends, by column.
  std::vector<std::map<std::string, std::string>> rows(const std::string& table) {
    const auto cells = [](const std::string& line) {
      std::vector<std::string> result{""};
      bool quoted = false;
      for (const char c : line)
        if (c == '"')
          quoted = !quoted;
        else if (c == ',' && !quoted)
          result.emplace_back();
        else
          result.back() += c;
      return result;
    };
    std::istringstream in(bytes(table));
    std::string line;
    std::getline(in, line);
    const auto header = cells(line);
    std::vector<std::map<std::string, std::string>> result;
    while (std::getline(in, line)) {
      const auto row = cells(line);
      EXPECT_EQ(row.size(), header.size()) << line;
      result.emplace_back();
      for (std::size_t i = 0; i < std::min(row.size(), header.size()); ++i) result.back()[header[i]] = row[i];
    }
    return result;
  }
  Words column(const std::string& table, const std::string& name) {
    Words values;
    for (auto& row : rows(table)) values.push_back(row[name]);
    return values;
  }
  void same_tables(const std::string& a, const std::string& b) {
    for (const char* file : {"samples.csv", "branches.csv", "index.html"}) {
      EXPECT_FALSE(bytes(a + "/" + file).empty()) << a << ' ' << file;
      EXPECT_EQ(bytes(a + "/" + file), bytes(b + "/" + file)) << file;
    }
  }

  /// Four shapes, of which one cannot be read.
  void make_samples() {
    fs::create_directories(folder / "scans");
    for (const char* name : {"s1", "s2", "s10"})
      folder.write("scans/" + std::string(name) + ".off", cube_off(false, name == std::string("s1") ? "1" : "1.5"));
    folder.write("scans/bad.off", "OFF\nnonsense");
    folder.write("scans/notes.md", "not a shape");
    folder.write("scans/s1.json", "{}");
  }

  /// Waits until nobody reads the FIFO any more.
  static void until_reader_is_gone(int fifo) {
    pollfd end{fifo, 0, 0};
    EXPECT_EQ(poll(&end, 1, -1), 1);
    EXPECT_TRUE(end.revents & POLLERR);
  }
  /// The process that `parent` has started.
  static pid_t child_of(pid_t parent) {
    for (const auto& entry : fs::directory_iterator("/proc")) {
      const std::string process = entry.path().filename().string();
      if (process.find_first_not_of("0123456789") != process.npos) continue;
      const std::string stat = bytes_of(entry.path() / "stat");
      const std::size_t name = stat.rfind(") ");
      if (name == stat.npos) continue;               // it has ended
      std::istringstream in(stat.substr(name + 4));  // behind the state
      pid_t above = 0;
      if (in >> above && above == parent) return std::stoi(process);
    }
    ADD_FAILURE() << "it has no child";
    return -1;
  }
  /// Starts a batch of the samples and returns when the second is being read: it is a FIFO, which answers nothing.
  Running stopped_at_second(const std::string& out, int& held) {
    make_samples();
    fs::rename(folder / "scans/s1.off", folder / "s1.off");
    const auto fifo = make_fifo("scans/s1.off");
    Running running = start_and_listen(line({"scans", "-o", out}));
    held = open_to_write(fifo);
    return running;
  }
  void put_file_for_fifo() { fs::rename(folder / "s1.off", folder / "scans/s1.off"); }
};

TEST_F(Batch, OneFolderAndOneRowPerSample) {
  make_samples();
  const Outcome outcome = batch(1, {"scans", "-o", "out"});
  EXPECT_NE(outcome.err.find("quench: 1 of 4 samples failed: 'bad'; 'out/samples.csv' says why\n"), std::string::npos);
  EXPECT_EQ(column("out/samples.csv", "name"), (Words{"bad", "s1", "s2", "s10"}));
  EXPECT_EQ(column("out/samples.csv", "file"),
            (Words{"scans/bad.off", "scans/s1.off", "scans/s2.off", "scans/s10.off"}));
  EXPECT_EQ(column("out/samples.csv", "status"), (Words{"failed", "ok", "ok", "ok"}));
  EXPECT_EQ(column("out/samples.csv", "components"), (Words{"", "1", "1", "1"}));
  EXPECT_TRUE(exists("out/s10/core.vtp"));
  EXPECT_FALSE(exists("out/bad/core.vtp"));
  const auto samples = rows("out/samples.csv");
  EXPECT_NE(samples[0].at("sentence").find("scans/bad.off"), std::string::npos);
  EXPECT_NE(bytes("out/bad/log.txt").find(samples[0].at("sentence")), std::string::npos);
  const auto names = column("out/branches.csv", "name");
  for (const auto& row : samples)
    EXPECT_EQ(std::to_string(std::ranges::count(names, row.at("name"))),
              row.at("status") == "ok" ? row.at("branches") : "0");
  EXPECT_TRUE(std::ranges::all_of(files(), [](const auto& file) { return !file.first.ends_with(".tmp"); }));
}

TEST_F(Batch, WhatIsDoneIsNotDoneAgain) {
  make_samples();
  batch(1, {"scans", "-o", "out"});
  const auto before = files();
  EXPECT_NE(batch(1, {"scans", "-o", "out"}).err.find("4 done already, 0 to do"), std::string::npos);
  EXPECT_EQ(files(), before);
  // Another number of threads or jobs changes nothing; --again is for what failed.
  EXPECT_NE(batch(1, {"scans", "-o", "out", "--threads", "1", "--jobs", "2"}).err.find("0 to do"), std::string::npos);
  EXPECT_NE(batch(1, {"scans", "-o", "out", "--again"}).err.find("3 done already, 1 to do"), std::string::npos);
  // The input changed; a result is gone; other options; a sample more.
  folder.write("scans/bad.off", cube_off());
  EXPECT_NE(batch(0, {"scans", "-o", "out"}).err.find("3 done already, 1 to do"), std::string::npos);
  fs::remove(folder / "out/s2/core.vtp");
  EXPECT_NE(batch(0, {"scans", "-o", "out"}).err.find("3 done already, 1 to do"), std::string::npos);
  EXPECT_TRUE(exists("out/s2/core.vtp"));
  folder.write("scans/s3.off", cube_off());
  EXPECT_NE(batch(0, {"scans", "-o", "out"}).err.find("4 done already, 1 to do"), std::string::npos);
  EXPECT_EQ(batch(0, {"scans", "-o", "out"}, {"--theta2", "inf"}).err.find("already"), std::string::npos);
}

TEST_F(Batch, DoneAgainNothingOldIsLeftButWhatOthersPutThere) {
  make_samples();
  fs::remove(folder / "scans/bad.off");
  works({"batch", "scans", "-o", "out", "--", "run", "--resolution", "8", "--no-view"});
  EXPECT_TRUE(exists("out/s1/picture.png"));
  folder.write("out/s1/my notes.txt", "mine");
  batch(0, {"scans", "-o", "out"});
  EXPECT_FALSE(exists("out/s1/picture.png"));
  EXPECT_TRUE(exists("out/s1/core.vtp"));
  EXPECT_EQ(bytes("out/s1/my notes.txt"), "mine");
  folder.write("scans/s1.off", "OFF\nbad");
  batch(1, {"scans", "-o", "out"});
  EXPECT_FALSE(exists("out/s1/core.vtp"));
  EXPECT_EQ(bytes("out/s1/my notes.txt"), "mine");
}

TEST_F(Batch, KilledAndStartedAgainTheTablesAreTheSame) {
  int held = -1;
  Running running = stopped_at_second("a/out", held);
  kill(running.child, SIGKILL);
  EXPECT_EQ(wait(running).code, 128 + SIGKILL);
  until_reader_is_gone(held);  // the sample ends with its batch
  close(held);
  EXPECT_FALSE(exists("a/out/samples.csv"));
  put_file_for_fifo();
  EXPECT_NE(batch(1, {"scans", "-o", "a/out"}).err.find("1 done already, 3 to do"), std::string::npos);
  batch(1, {"scans", "-o", "b/out"});
  same_tables("a/out", "b/out");
}

TEST_F(Batch, ASampleInWorkIsLeftToTheRunThatHasIt) {
  int held = -1;
  Running running = stopped_at_second("a/out", held);
  EXPECT_NE(batch(1, {"scans", "-o", "a/out"}).err.find("note: 1 sample left to another run of this batch"),
            std::string::npos);
  EXPECT_EQ(column("a/out/samples.csv", "status"), (Words{"failed", "missing", "ok", "ok"}));
  // What a run that is killed may leave is removed by the next one.
  folder.write("a/out/s1/core.vtp", "half");
  kill(running.child, SIGKILL);
  wait(running);
  until_reader_is_gone(held);
  close(held);
  fs::remove(folder / "scans/s1.off");
  folder.write("scans/s1.off", "OFF\nbad");
  batch(1, {"scans", "-o", "a/out"});
  EXPECT_FALSE(exists("a/out/s1/core.vtp"));
}

// As by Ctrl-C, which programs in the background may ignore.
TEST_F(Batch, StoppedItEndsTheSamplesAndLeavesWhatIsDone) {
  int held = -1;
  Running running = stopped_at_second("a/out", held);
  kill(running.child, SIGTERM);
  const Outcome outcome = wait(running);
  EXPECT_EQ(outcome.code, 130);
  EXPECT_TRUE(
      outcome.err.ends_with("quench: interrupted; 1 of 4 samples is done, and the same command does the rest\n"))
      << outcome.err;
  until_reader_is_gone(held);
  close(held);
  put_file_for_fifo();
  EXPECT_NE(batch(1, {"scans", "-o", "a/out"}).err.find("1 done already, 3 to do"), std::string::npos);
  batch(1, {"scans", "-o", "b/out"});
  same_tables("a/out", "b/out");
}

TEST_F(Batch, ACrashIsARowAndTriedAgain) {
  int held = -1;
  Running running = stopped_at_second("a/out", held);
  kill(child_of(running.child), SIGSEGV);
  const Outcome outcome = wait(running);
  close(held);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(column("a/out/samples.csv", "status"), (Words{"failed", "failed", "ok", "ok"}));
  EXPECT_EQ(rows("a/out/samples.csv")[1]["sentence"], "it was ended by a signal: Segmentation fault");
  fs::remove(folder / "scans/s1.off");
  put_file_for_fifo();
  batch(1, {"scans", "-o", "a/out"});
  batch(1, {"scans", "-o", "b/out"});
  same_tables("a/out", "b/out");
}

TEST_F(Batch, AFailureOfTheMachineIsTriedAgain) {
  folder.write("list.txt", "gone.off\n");
  batch(1, {"list.txt", "-o", "out"});
  EXPECT_EQ(rows("out/samples.csv")[0]["sentence"], "'gone.off' does not exist");
  EXPECT_EQ(batch(1, {"list.txt", "-o", "out"}).err.find("already"), std::string::npos);
}

TEST_F(Batch, JobsAndShardsMakeTheSameTables) {
  make_samples();
  batch(1, {"scans", "-o", "a/out"});
  batch(1, {"scans", "-o", "b/out", "--jobs", "3", "--memory-limit", "3G"});
  same_tables("a/out", "b/out");
  // Two at the same time, then the third.
  const pid_t first = start(line({"scans", "-o", "c/out", "--shard", "1/3"}));
  batch(0, {"scans", "-o", "c/out", "--shard", "2/3"});
  EXPECT_EQ(wait(first).code, 1);
  EXPECT_EQ(column("c/out/samples.csv", "status"), (Words{"failed", "ok", "missing", "ok"}));
  const Outcome collected = batch(1, {"scans", "-o", "c/out", "--collect"});
  EXPECT_NE(collected.err.find("1 of 4 samples failed: 'bad'"), std::string::npos);
  EXPECT_FALSE(exists("c/out/s2"));
  batch(0, {"scans", "-o", "c/out", "--shard", "3/3"});
  same_tables("a/out", "c/out");
  for (const char* file : {"samples.csv", "branches.csv", "index.html"}) fs::remove(folder / "c/out" / file);
  batch(1, {"scans", "-o", "c/out", "--collect"});
  same_tables("a/out", "c/out");
}

// What is there is not what these options make.
TEST_F(Batch, TablesHoldOnlyWhatBelongsToTheOptions) {
  make_samples();
  fs::remove(folder / "scans/bad.off");
  batch(0, {"scans", "-o", "out"});
  const Outcome other = batch(1, {"scans", "-o", "out", "--collect"}, {"--theta2", "inf"});
  EXPECT_NE(other.err.find("quench: 3 of 3 samples are not done"), std::string::npos) << other.err;
  EXPECT_EQ(column("out/samples.csv", "status"), (Words{"missing", "missing", "missing"}));
}

// ------------------------------------------------------------------------------------------------- names and lists

TEST_F(Batch, NamesThatClashAreToldApart) {
  for (const char* name : {"day1/root.off", "day2/root.off", "day2/Stem.off", "day2/stem.stl", "day1/leaf.off"}) {
    fs::create_directories((folder / name).parent_path());
    folder.write(name, cube_off());
  }
  batch(1, {"day1", "day2/*", "day1/leaf.off", "-o", "out"});
  EXPECT_EQ(column("out/samples.csv", "name"),
            (Words{"leaf", "day1_root", "Stem.off", "day2_root", "stem.stl", "leaf_2"}));
}

TEST_F(Batch, AListMayGiveNamesOptionsAndMore) {
  make_samples();
  folder.write("scans/list.csv",
               "\xEF\xBB\xBFpath;genotype;name;options\r\n# a comment\r\ns1.off;B73;first;\r\n\r\n"
               "\"s2.off\";\"Mo 17\";;--theta2 'inf' --resolution=9\r\ns10.off;;last\r\n");
  batch(0, {"scans/list.csv", "-o", "out"});
  EXPECT_EQ(column("out/samples.csv", "name"), (Words{"first", "s2", "last"}));
  EXPECT_EQ(column("out/samples.csv", "file"), (Words{"scans/s1.off", "scans/s2.off", "scans/s10.off"}));
  EXPECT_EQ(column("out/samples.csv", "genotype"), (Words{"B73", "Mo 17", ""}));
  EXPECT_EQ(column("out/samples.csv", "options"), (Words{"", "--theta2 'inf' --resolution=9", ""}));
  EXPECT_EQ(column("out/samples.csv", "theta2")[1], "inf");
  EXPECT_NE(bytes("out/s2/report.json").find("\"resolution\": 9"), std::string::npos);
  EXPECT_NE(bytes("out/last/report.json").find("\"resolution\": 8"), std::string::npos);
  // A name of a column that is taken.
  folder.write("list.tsv", "file\tcomponents\tstatus\nscans/s1.off\tmine\tgood\n");
  batch(0, {"list.tsv", "-o", "tsv"});
  const auto row = rows("tsv/samples.csv").at(0);
  EXPECT_EQ(row.at("listed_components"), "mine");
  EXPECT_EQ(row.at("listed_status"), "good");
  EXPECT_EQ(row.at("components"), "1");
  EXPECT_EQ(row.at("status"), "ok");
}

TEST_F(Batch, NamesAndSentencesAreQuotedAndEscaped) {
  const std::string name = "a, \"b\" <i>&\xC3\xA4#1%";
  folder.write(name + ".off", "OFF\nnonsense");
  folder.write("-v.off", cube_off());
  folder.write("list.txt", "# two samples\n  " + name + ".off  \n\n-v.off\n");
  batch(1, {"list.txt", "-o", "out"});
  const std::string table = bytes("out/samples.csv"), page = bytes("out/index.html");
  const std::string quoted = "a, \"\"b\"\" <i>&\xC3\xA4#1%";
  EXPECT_NE(table.find("\n\"" + quoted + "\",\"" + quoted + ".off\",failed,\""), std::string::npos) << table;
  EXPECT_NE(table.find("\n-v,-v.off,ok,,"), std::string::npos) << table;
  EXPECT_EQ(page.find(name), std::string::npos);
  EXPECT_NE(page.find("a, &quot;b&quot; &lt;i&gt;&amp;\xC3\xA4#1%</span></h2>"), std::string::npos);
  EXPECT_NE(page.find("href=\"./a%2C%20%22b%22%20%3Ci%3E%26%C3%A4%231%25/log.txt\""), std::string::npos);
  for (const char* outside : {"http:", "https:", "//cdn", "@import", "url("})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
}

TEST_F(Batch, SamplesOfOtherKindsHaveTheUnionOfTheColumns) {
  folder.write("a.off", cube_off());
  folder.write("b.pgm", "P2\n4 4\n1\n0 0 0 0\n0 1 1 0\n0 1 1 0\n0 0 0 0\n");
  batch(0, {"b.pgm", "a.off", "-o", "out"});
  const auto samples = rows("out/samples.csv");
  EXPECT_EQ(samples[0].at("pixels"), "4");
  EXPECT_EQ(samples[0].at("voxels"), "");
  EXPECT_EQ(samples[1].at("pixels"), "");
  EXPECT_EQ(samples[1].at("theta1").empty(), false);
}

// Trees: the row of traits.csv, and all axes.
TEST_F(Batch, ADamagedTableIsAFailureOfItsSampleAndMadeAgain) {
  folder.write("a.swc", "1 2 0 0 0 1 -1\n2 2 0 0 -5 1 1\n");
  folder.write("b.swc", "1 2 0 0 0 1 -1\n2 2 0 0 -7 1 1\n");
  const Words line{"batch", ".", "-o", "out", "--", "--no-view", "--no-picture"};
  works(line);
  const std::string good = bytes("out/axes.csv");
  folder.write("out/a/axes.csv", "id,note\n0,\"not closed\n");
  Words collect = line;
  collect.insert(collect.begin() + 4, "--collect");
  const Outcome damaged = quench(collect);
  EXPECT_EQ(damaged.code, 1);
  EXPECT_NE(damaged.err.find("1 of 2 samples failed: 'a'"), std::string::npos) << damaged.err;
  EXPECT_EQ(column("out/samples.csv", "status"), (Words{"failed", "ok"}));
  EXPECT_NE(rows("out/samples.csv")[0]["sentence"].find("axes.csv"), std::string::npos);
  EXPECT_EQ(column("out/axes.csv", "name"), (Words{"b"}));
  works(line);
  EXPECT_EQ(bytes("out/axes.csv"), good);
}

TEST_F(Batch, SaysWhereDownDiffers) {
  folder.write("a.swc", "1 2 0 0 0 1 -1\n2 2 0 0 -5 1 1\n");
  folder.write("b.swc", "1 2 0 0 0 1 -1\n2 2 0 0 -7 1 1\n");
  folder.write("c.swc", "1 2 0 0 0 1 -1\n2 2 0 0 7 1 1\n");
  const Words line{"batch", ".", "-o", "out", "--", "--no-view", "--no-picture"};
  EXPECT_NE(works(line).err.find("note: down is +z of 1 sample ('c') and -z of 2 samples ('a' ...)"),
            std::string::npos);
  EXPECT_EQ(column("out/samples.csv", "down"), (Words{"-z", "-z", "+z"}));
  Words same = line;
  same.insert(same.end(), {"--down", "-z"});
  EXPECT_EQ(works(same).err.find("note: down"), std::string::npos);
}

TEST_F(Batch, TreesGiveTraitsAndAxes) {
  const std::string stem = "1 2 0 0 0 1 -1\n2 2 0 0 -5 1 1\n3 2 0 0 -9 1 2\n";
  folder.write("straight.swc", stem);
  folder.write("forked.swc", stem + "4 2 3 0 -7 0.5 2\n");
  folder.write("picture.png", "not of space");
  const Words line{"batch", ".", "-o", "out", "--", "--no-view", "--no-picture"};
  works(line);
  EXPECT_EQ(column("out/samples.csv", "name"), (Words{"forked", "straight"}));
  EXPECT_EQ(column("out/samples.csv", "axes"), (Words{"2", "1"}));
  EXPECT_EQ(column("out/axes.csv", "name"), (Words{"forked", "forked", "straight"}));
  EXPECT_FALSE(exists("out/branches.csv"));

  folder.write("out/forked/traits.csv", "axes,odd [mm]\n7,\"1,5\"\n");
  folder.write("out/straight/axes.csv", "length [mm],id\n2,0\n3,1\n");
  Words again = line;
  again.insert(again.begin() + 4, "--collect");
  works(again);
  EXPECT_EQ(column("out/samples.csv", "axes"), (Words{"7", "1"}));
  EXPECT_EQ(column("out/samples.csv", "odd [mm]"), (Words{"1,5", ""}));
  EXPECT_EQ(column("out/samples.csv", "tips").at(0), "");
  const auto axes = rows("out/axes.csv");
  EXPECT_EQ(column("out/axes.csv", "name"), (Words{"forked", "forked", "straight", "straight"}));
  EXPECT_EQ(axes[0].at("length [mm]"), "");
  EXPECT_EQ(axes[2].at("length [mm]"), "2");
  EXPECT_EQ(axes[3].at("id"), "1");
}

// -------------------------------------------------------------------------------------------------------- refusals

TEST_F(Batch, RefusesWhatCannotBe) {
  make_samples();
  fs::create_directories(folder / "empty");
  folder.write("none.txt", "# nothing\n\n");
  folder.write("none.csv", "");
  folder.write("header.csv", "scans/s1.off\n");
  folder.write("twice.csv", "file,name\nscans/s1.off,x\nscans/s2.off,X\n");
  folder.write("slash.csv", "file,name\nscans/s1.off,../x\n");
  folder.write("many.csv", "file\nscans/s1.off,1,2\n");
  folder.write("open.csv", "file,name\nscans/s1.off,\"x\n");
  folder.write("quote.csv", "file,options\nscans/s1.off,--theta2 'x\n");
  folder.write("wrong.csv", "file,options\nscans/s1.off,--bogus\n");
  folder.write("what.xyz", "");
  const auto refuse = [&](int code, const Words& words, const Words& arguments, const Words& options = {}) {
    refuses(code, words, line(arguments, options));
  };
  refuse(3, {"no sample", "'empty' holds no file"}, {"empty", "-o", "out"});
  refuse(3, {"no sample", "'none.txt' names no file"}, {"none.txt", "-o", "out"});
  refuse(3, {"no sample", "'none.csv' names no file"}, {"none.csv", "-o", "out"});
  refuse(3, {"begins with the file 'scans/s1.off'"}, {"header.csv", "-o", "out"});
  refuse(3, {"'twice.csv' line 3", "'X' is taken"}, {"twice.csv", "-o", "out"});
  refuse(3, {"'slash.csv' line 2", "'../x'"}, {"slash.csv", "-o", "out"});
  refuse(3, {"'many.csv' line 2 has 3 cells"}, {"many.csv", "-o", "out"});
  refuse(3, {"'open.csv' line 2", "not closed"}, {"open.csv", "-o", "out"});
  refuse(3, {"'quote.csv' line 2", "not closed in its options"}, {"quote.csv", "-o", "out"});
  refuse(2, {"options of 's1'", "--bogus"}, {"wrong.csv", "-o", "out"});
  refuse(2, {"'what.xyz' is neither a shape"}, {"what.xyz", "-o", "out"});
  refuse(2, {"'none.txt' must be given alone"}, {"none.txt", "scans", "-o", "out"});
  refuse(1, {"'absent.off' does not exist"}, {"absent.off", "-o", "out"});
  refuse(1, {"matches 'scans/*.nrrd'"}, {"scans/*.nrrd", "-o", "out"});
  refuse(2, {"--shard '4/3'"}, {"scans", "-o", "out", "--shard", "4/3"});
  refuse(2, {"--shard '0/3'"}, {"scans", "-o", "out", "--shard", "0/3"});
  refuse(2, {"--jobs"}, {"scans", "-o", "out", "--jobs", "0"});
  refuse(2, {"--bogus"}, {"scans", "-o", "out"}, {"--bogus", "1"});
  refuse(2, {"--theta2 needs a value"}, {"scans", "-o", "out"}, {"--theta2"});
  refuse(2, {"one argument too many"}, {"scans", "-o", "out"}, {"more.off"});
  for (const char* own : {"-o", "--output=x", "--threads", "--memory-limit", "--overwrite", "--json", "--help"})
    refuse(2, {own[1] == 'o' ? "-o" : std::string(own).substr(0, std::string(own).find('='))}, {"scans", "-o", "out"},
           {own});
  refuses(2, {"'verify' is neither"}, {"batch", "scans", "-o", "out", "--", "verify"});
  for (const char* asked : {"--help", "-h", "--version", "--xml"})
    refuses(2, {std::string("leave out ") + asked, "measures nothing"},
            {"batch", "scans", "-o", "out", "--", "run", asked});
}

TEST_F(Batch, ReplacesOnlyItsOwnOutputs) {
  make_samples();
  fs::remove(folder / "scans/bad.off");
  const auto refuse = [&](const std::string& word) { refuses(2, {word, "--overwrite"}, line({"scans", "-o", "out"})); };
  fs::create_directories(folder / "out/s2");
  folder.write("out/samples.csv", "precious");
  refuse("'out/samples.csv' exists");
  fs::remove(folder / "out/samples.csv");
  folder.write("out/s2/data", "precious");
  refuse("'out/s2' exists");
  refuses(2, {"-o names the folder of the samples"}, line({"scans", "-o", "scans/."}));
  folder.write("file", "");
  refuses(2, {"file' exists and is not a folder"}, line({"scans", "-o", "file"}));
  batch(0, {"scans", "-o", "out", "--overwrite"});
  EXPECT_EQ(bytes("out/s2/data"), "precious");
  batch(0, {"scans", "-o", "out"});
}

}  // namespace program_batch_test
