// A scene file of a test's own, in a folder that goes away with the test.
#pragma once
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "models/errors.hpp"
#include "models/scene.hpp"

namespace polhode {

class SceneFile : public testing::Test {
 protected:
  SceneFile() {
    std::string pattern = (std::filesystem::temp_directory_path() / "polhode-scene-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~SceneFile() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& text, const std::string& name = "scene.toml") const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  Scene read(const std::string& text) const { return read_scene(write(text)); }
  // The message of the InputError that reading must end in.
  std::string refusal(const std::string& text) const { return refusal_of(write(text)); }
  static std::string refusal_of(const std::filesystem::path& file) {
    try {
      read_scene(file);
    } catch (const InputError& e) {
      EXPECT_EQ(e.exit_code, 65);
      return e.what();
    }
    return "(read without complaint)";
  }

  std::filesystem::path folder_;
};

}  // namespace polhode
