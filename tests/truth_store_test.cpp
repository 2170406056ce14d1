// The store of truths on disk: what is written comes back, or nothing does.
#include "experiments/truth_store.hpp"

#include <algorithm>
#include <fstream>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/command.hpp"

namespace polhode {
namespace {

namespace fs = std::filesystem;

/// No test reads or writes the cache of the user, nor does a program that a test runs.
class CacheOfTests : public testing::Environment {
 public:
  void SetUp() override { setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1); }

 private:
  TemporaryFolder folder_;
};
const auto* const cache_of_tests = testing::AddGlobalTestEnvironment(new CacheOfTests);

class StoreOfTruths : public testing::Test {
 protected:
  TemporaryFolder outer_;
  fs::path folder_ = outer_.path() / "polhode" / "truths";
  TruthStore store_{folder_, "version 1"};

  std::vector<fs::path> files() const {
    std::vector<fs::path> all;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored)) all.push_back(entry.path());
    return all;
  }
  static mode_t mode_of(const fs::path& place) {
    struct stat there {};
    EXPECT_EQ(lstat(place.c_str(), &there), 0) << place;
    return there.st_mode & 07777;
  }
  /// So many seconds ago.
  static void age(const fs::path& place, std::time_t seconds) {
    const timespec then{std::time(nullptr) - seconds, 0};
    const timespec times[] = {then, then};
    ASSERT_EQ(utimensat(AT_FDCWD, place.c_str(), times, 0), 0);
  }
};

TEST_F(StoreOfTruths, GivesBackWhatWasWritten) {
  EXPECT_FALSE(store_.read("key"));
  const std::string payload("digits\0and\nzeros\xff", 17), empty;
  store_.write("key", payload);
  store_.write("", empty);
  store_.write("other", "1");
  store_.write("other", "2");
  EXPECT_EQ(store_.read("key"), payload);
  EXPECT_EQ(store_.read(""), empty);
  EXPECT_EQ(store_.read("other"), "2");
  EXPECT_FALSE(store_.read("keys"));
  EXPECT_EQ(files().size(), 3U);  // nothing else is left
  EXPECT_EQ(TruthStore(folder_, "version 1").read("key"), payload);
}

TEST_F(StoreOfTruths, IsForTheUserAlone) {
  const mode_t before = umask(0);
  store_.write("key", "payload");
  umask(before);
  EXPECT_EQ(mode_of(folder_), 0700U);
  EXPECT_EQ(mode_of(folder_.parent_path()), 0700U);
  EXPECT_EQ(mode_of(store_.place_of("key")), 0600U);
}

TEST_F(StoreOfTruths, NoFlippedBitPasses) {
  store_.write("key", "payload");
  const fs::path place = store_.place_of("key");
  const std::string whole = text_of(place);
  for (std::size_t i = 0; i < whole.size(); ++i)
    for (const int bit : {0, 7}) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      std::ofstream(place, std::ios::binary) << damaged;
      EXPECT_FALSE(store_.read("key")) << "byte " << i;
    }
  std::ofstream(place, std::ios::binary) << whole;
  EXPECT_EQ(store_.read("key"), "payload");
}

TEST_F(StoreOfTruths, NoTruncatedOrLongerFilePasses) {
  store_.write("key", "payload");
  const fs::path place = store_.place_of("key");
  const std::string whole = text_of(place);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::ofstream(place, std::ios::binary) << whole.substr(0, size);
    EXPECT_FALSE(store_.read("key")) << size << " bytes";
  }
  std::ofstream(place, std::ios::binary) << whole << 'x';
  EXPECT_FALSE(store_.read("key"));
  std::ofstream(place, std::ios::binary) << whole;
  EXPECT_EQ(store_.read("key"), "payload");
}

TEST_F(StoreOfTruths, AnotherVersionReadsNothingAndReplacesIt) {
  store_.write("key", "payload");
  const TruthStore other(folder_, "version 2");
  EXPECT_FALSE(other.read("key"));
  other.write("key", "better");
  EXPECT_EQ(other.read("key"), "better");
  EXPECT_FALSE(store_.read("key"));
  EXPECT_EQ(files().size(), 1U);
}

TEST_F(StoreOfTruths, ACollisionOfHashesIsHarmless) {
  store_.write("key", "payload");
  fs::copy_file(store_.place_of("key"), store_.place_of("another"));
  EXPECT_FALSE(store_.read("another"));
}

TEST_F(StoreOfTruths, WritersAtOnceLeaveOneWholeBlob) {
  const auto payload_of = [](char c) { return std::string(200'000, c); };
  std::vector<pid_t> children;
  for (char c = 'a'; c < 'e'; ++c) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      bool whole = true;
      for (int i = 0; i < 25; ++i) {
        store_.write("key", payload_of(c));
        const auto read = store_.read("key");
        whole = whole && read && *read == payload_of(read->front());
      }
      _exit(whole ? 0 : 1);
    }
    children.push_back(child);
  }
  {
    std::vector<std::jthread> threads;
    for (char c = 'e'; c < 'h'; ++c)
      threads.emplace_back([&, c] {
        for (int i = 0; i < 25; ++i) store_.write("key", payload_of(c));
      });
  }
  for (const pid_t child : children) {
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  }
  const auto last = store_.read("key");
  ASSERT_TRUE(last);
  EXPECT_EQ(*last, payload_of(last->front()));
  EXPECT_EQ(files().size(), 1U);
}

TEST_F(StoreOfTruths, WhatWasNotUsedForLongestGoes) {
  const TruthStore store(folder_, "version 1", {5000, 2000});
  const std::string payload(1000, 'x');
  store.write("a", payload);
  age(store.place_of("a"), 300);
  store.write("b", payload);
  age(store.place_of("b"), 200);
  store.write("c", payload);
  age(store.place_of("c"), 100);
  EXPECT_TRUE(store.read("a"));  // used now
  store.write("d", payload);
  EXPECT_TRUE(store.read("b"));  // four fit
  age(store.place_of("b"), 200);
  store.write("e", payload);
  EXPECT_FALSE(store.read("b"));
  for (const char* key : {"a", "c", "d", "e"}) EXPECT_TRUE(store.read(key)) << key;
  std::uintmax_t all = 0;
  for (const fs::path& file : files()) all += fs::file_size(file);
  EXPECT_LE(all, 5000U);
}

TEST_F(StoreOfTruths, OneThatIsTooLargeIsNotKept) {
  const TruthStore store(folder_, "version 1", {5000, 2000});
  store.write("key", std::string(2000, 'x'));
  EXPECT_TRUE(store.read("key"));
  store.write("key", std::string(2001, 'y'));
  EXPECT_EQ(store.read("key"), std::string(2000, 'x'));
}

TEST_F(StoreOfTruths, AFolderThatCannotBeKeepsNothing) {
  const TruthStore nowhere;
  nowhere.write("key", "payload");
  EXPECT_FALSE(nowhere.read("key"));
  const TruthStore in_a_file(outer_.write("file", "x") / "truths", "version 1");
  in_a_file.write("key", "payload");
  EXPECT_FALSE(in_a_file.read("key"));
  const TruthStore in_proc("/proc/self/truths", "version 1");
  in_proc.write("key", "payload");
  EXPECT_FALSE(in_proc.read("key"));
  store_.write("key", "payload");
  ASSERT_EQ(chmod(folder_.c_str(), 0500), 0);
  store_.write("key", "other");  // root may all the same
  EXPECT_EQ(store_.read("key"), geteuid() == 0 ? "other" : "payload");
  chmod(folder_.c_str(), 0700);
}

TEST_F(StoreOfTruths, ALinkInItsPlaceIsReplacedNotFollowed) {
  store_.write("key", "payload");
  const fs::path place = store_.place_of("key"), elsewhere = outer_.path() / "elsewhere";
  fs::rename(place, elsewhere);
  fs::create_symlink(elsewhere, place);
  EXPECT_FALSE(store_.read("key"));  // though what it points to is whole
  const std::string before = text_of(elsewhere);
  store_.write("key", "other");
  EXPECT_FALSE(fs::is_symlink(place));
  EXPECT_EQ(store_.read("key"), "other");
  EXPECT_EQ(text_of(elsewhere), before);
}

TEST_F(StoreOfTruths, WhatIsNoFileIsNoTruth) {
  store_.write("key", "payload");
  fs::remove(store_.place_of("key"));
  ASSERT_EQ(mkfifo(store_.place_of("key").c_str(), 0600), 0);
  EXPECT_FALSE(store_.read("key"));  // and does not wait for a writer
  fs::create_directories(store_.place_of("folder") / "in it");
  store_.write("folder", "payload");
  EXPECT_FALSE(store_.read("folder"));
}

TEST_F(StoreOfTruths, StrayTemporariesGoAndFilesOfOthersStay) {
  store_.write("key", "payload");
  const auto put = [this](const char* name) {
    std::ofstream(folder_ / name) << "x";
    return folder_ / name;
  };
  const fs::path stray = put(".writing-abcdef"), at_work = put(".writing-ghijkl"), other = put("notes");
  age(stray, 3700);
  age(at_work, 3500);
  age(other, 1'000'000);
  store_.write("key", "other");
  EXPECT_FALSE(fs::exists(stray));
  EXPECT_TRUE(fs::exists(at_work));
  EXPECT_TRUE(fs::exists(other));
}

TEST(StoreOfTheUser, LiesWhereTheSpecificationSays) {
  const std::string cache = getenv("XDG_CACHE_HOME"), home = getenv("HOME") ? getenv("HOME") : "";
  const auto place = [] { return TruthStore::of_user().place_of("key").parent_path(); };
  EXPECT_EQ(place(), fs::path(cache) / "polhode" / "truths");
  setenv("HOME", "/nowhere/home", 1);
  for (const char* not_absolute : {"", "relative"}) {
    setenv("XDG_CACHE_HOME", not_absolute, 1);
    EXPECT_EQ(place(), "/nowhere/home/.cache/polhode/truths");
  }
  unsetenv("XDG_CACHE_HOME");
  unsetenv("HOME");
  TruthStore::of_user().write("key", "payload");
  EXPECT_FALSE(TruthStore::of_user().read("key"));
  setenv("XDG_CACHE_HOME", cache.c_str(), 1);
  if (!home.empty()) setenv("HOME", home.c_str(), 1);
}

}  // namespace
}  // namespace polhode
