// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/true_objects.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "temporary_folder.h"

namespace kestrel {
namespace {

class TrueObjectsTest : public ::testing::Test {
 protected:
  std::vector<TrueObject> read(const std::string& text) {
    std::ofstream(path_) << text;
    return readTrueObjects(path_, {}, "");
  }

  std::string problemOf(const std::string& text) {
    try {
      read(text);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("truth.csv");
};

TEST_F(TrueObjectsTest, ATextIsSortedByStamp) {
  const auto objects = read("stamp,id,x,y\n2.5,7,1.0,-2.0\n1.5,3,0.5,0.25,ignored\n");
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[0].stamp, 1.5);
  EXPECT_EQ(objects[0].id, 3);
  EXPECT_EQ(objects[0].position, Eigen::Vector2d(0.5, 0.25));
  EXPECT_EQ(objects[1].id, 7);
}

TEST_F(TrueObjectsTest, ABadLineIsNamed) {
  EXPECT_EQ(problemOf("1.0,2,3.0,4.0\n1.0,2,3.0\n"), path_ + ":2: expected stamp,id,x,y");
  EXPECT_EQ(problemOf("stamp,id,x,y\n"), path_ + ": has no true positions");
}

}  // namespace
}  // namespace kestrel
