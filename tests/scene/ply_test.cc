#include "colmap_ext/scene/ply.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

constexpr const char* kTriangle =
    "ply\n"
    "format ascii 1.0\n"
    "comment made by hand\n"
    "obj_info nothing\n"
    "element vertex 3\n"
    "property float x\n"
    "property double y\n"
    "property uchar red\n"
    "element face 1\n"
    "property list uchar int vertex_indices\n"
    "property short flags\n"
    "end_header\n"
    "0 1e-3 255\n"
    "+1.5 -2 0\n"
    "nan 3 7\n"
    "3 0 1 2 -5\n";

PlyData AllTypes() {
  PlyElement element;
  element.name = "thing";
  element.count = 3;
  element.scalars = {{"a", PlyType::kInt8, {-128, 0, 127}},
                     {"b", PlyType::kUInt8, {0, 1, 255}},
                     {"c", PlyType::kInt16, {-32768, 1, 32767}},
                     {"d", PlyType::kUInt16, {0, 1, 65535}},
                     {"e", PlyType::kInt32, {-2147483648.0, 1, 2147483647.0}},
                     {"f", PlyType::kUInt32, {0, 1, 4294967295.0}},
                     {"g", PlyType::kFloat32, {0.5, -1e30F, 3}},
                     {"h", PlyType::kFloat64, {0.1, 1e-300, std::nextafter(1.0, 2.0)}}};
  PlyList list;
  list.name = "items";
  list.count_type = PlyType::kUInt16;
  list.item_type = PlyType::kFloat64;
  list.starts = {0, 0, 2, 3};
  list.items = {0.1, 0.2, 0.3};
  element.lists.push_back(list);
  PlyData data;
  data.comments = {"one", "two words", ""};
  data.elements.push_back(element);
  return data;
}

TEST(Ply, EveryTypeComesBackToTheLastBit) {
  const TestFolder folder;
  const PlyData written = AllTypes();
  WritePly(written, folder / "a.ply");
  const PlyData read = ReadPly(folder / "a.ply");
  EXPECT_EQ(read.comments, written.comments);
  ASSERT_EQ(read.elements.size(), 1U);
  ASSERT_EQ(read.elements[0].scalars.size(), written.elements[0].scalars.size());
  for (const PlyScalar& scalar : written.elements[0].scalars) {
    const PlyScalar* found = read.elements[0].FindScalar(scalar.name);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->type, scalar.type);
    EXPECT_EQ(found->values, scalar.values) << scalar.name;
  }
  const PlyList* list = read.elements[0].FindList("items");
  ASSERT_NE(list, nullptr);
  EXPECT_EQ(list->starts, written.elements[0].lists[0].starts);
  EXPECT_EQ(list->items, written.elements[0].lists[0].items);
  EXPECT_EQ(list->NumRows(), 3U);
  EXPECT_EQ(read.FindElement("vertex"), nullptr);
}

TEST(Ply, AsciiIsReadWithListsBetweenScalars) {
  const TestFolder folder;
  WriteFileAtomically(folder / "a.ply", kTriangle);
  const PlyData data = ReadPly(folder / "a.ply");
  EXPECT_EQ(data.comments, std::vector<std::string>{"made by hand"});
  const PlyElement* vertices = data.FindElement("vertex");
  ASSERT_NE(vertices, nullptr);
  EXPECT_EQ(vertices->FindScalar("x")->values[1], 1.5);
  EXPECT_TRUE(std::isnan(vertices->FindScalar("x")->values[2]));
  EXPECT_EQ(vertices->FindScalar("y")->values, (std::vector<double>{1e-3, -2, 3}));
  const PlyElement* faces = data.FindElement("face");
  ASSERT_NE(faces, nullptr);
  EXPECT_EQ(faces->FindList("vertex_indices")->items, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(faces->FindScalar("flags")->values, std::vector<double>{-5});
}

TEST(Ply, WindowsLineEndsAndAMissingLastLineEndAreRead) {
  const TestFolder folder;
  std::string text;
  for (const char c : std::string(kTriangle))
    text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  text.resize(text.size() - 2);
  WriteFileAtomically(folder / "a.ply", text);
  EXPECT_EQ(ReadPly(folder / "a.ply").FindElement("face")->FindScalar("flags")->values[0], -5);
}

// Whatever is cut off, the reader says so; it never returns half a file.
TEST(Ply, EveryTruncationIsAnError) {
  const TestFolder folder;
  WritePly(AllTypes(), folder / "binary.ply");
  const std::string binary = ReadFile(folder / "binary.ply");
  for (std::size_t size = 1; size < binary.size(); ++size) {
    WriteFileAtomically(folder / "cut.ply", binary.substr(0, size));
    ExpectError([&] { ReadPly(folder / "cut.ply"); }, {"cut.ply"});
  }
  const std::string ascii = kTriangle;
  for (std::size_t size = 1; size + 2 < ascii.size();
       ++size) {  // "-5" may lose its line end, not 5
    WriteFileAtomically(folder / "cut.ply", ascii.substr(0, size));
    ExpectError([&] { ReadPly(folder / "cut.ply"); }, {"cut.ply: line "});
  }
}

struct BadPly {
  std::string from;
  std::string to;
  std::string message;
};

TEST(Ply, BadTextIsNamedByItsLine) {
  const TestFolder folder;
  const std::vector<BadPly> cases = {
      {"ply\n", "obj\n", "line 1: this is no PLY file"},
      {"ascii", "binary_big_endian", "line 2: format binary_big_endian is not supported"},
      {"format ascii 1.0\n", "", "no format line"},
      {"element vertex 3", "element vertex -3", "line 5: expected 'element"},
      {"element vertex 3", "element vertex 1e14", "does not fit into the rest of the file"},
      {"element vertex 3", "element vertex 4", "values where 3 were expected"},
      {"element vertex 3", "element vertex 2", "line 15: 'nan' is no value for the length of"},
      {"element face", "element vertex", "line 9: element vertex is declared twice"},
      {"double y", "double x", "line 7: property x is declared twice"},
      {"double y", "real y", "line 7: unknown number type 'real'"},
      {"list uchar", "list float", "line 10: the length of a list must be an integer"},
      {"0 1e-3 255", "0 1e-3 256", "line 13: '256' is no value for red (uchar)"},
      {"0 1e-3 255", "0 1e-3", "line 13: the value of red is missing"},
      {"0 1e-3 255", "0 1e-3 255 1", "line 13: 4 values where 3 were expected"},
      {"0 1e-3 255", "0 1e-3x 255", "line 13: '1e-3x' is no value for y"},
      {"3 0 1 2 -5", "3 0 1 2 -5\n\n1 2", "line 18: more rows"},
      {"3 0 1 2 -5", "200 0 1 2 -5", "line 16: the value of vertex_indices is missing"},
      {"obj_info", "something", "line 4: unknown header word 'something'"},
  };
  for (const BadPly& bad : cases) {
    std::string text = kTriangle;
    const auto at = text.find(bad.from);
    ASSERT_NE(at, std::string::npos) << bad.from;
    text.replace(at, bad.from.size(), bad.to);
    WriteFileAtomically(folder / "bad.ply", text);
    ExpectError([&] { ReadPly(folder / "bad.ply"); }, {"bad.ply", bad.message});
  }
}

TEST(Ply, AHeaderThatPromisesTooMuchAllocatesNothing) {
  const TestFolder folder;
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement face 1\n"
      "property list uint double a\nend_header\n";
  WriteFileAtomically(folder / "list.ply", header + "\xFF\xFF\xFF\xFF");
  ExpectError([&] { ReadPly(folder / "list.ply"); },
              {"list.ply: byte ", "a list of 4294967295 items does not fit"});
  WriteFileAtomically(folder / "rows.ply",
                      "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000\n"
                      "property uchar a\nend_header\nabc");
  ExpectError([&] { ReadPly(folder / "rows.ply"); }, {"rows.ply: byte ", "does not fit"});
  WriteFileAtomically(folder / "none.ply",
                      "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000\n"
                      "end_header\n");
  ExpectError([&] { ReadPly(folder / "none.ply"); }, {"none.ply", "has no properties"});
}

TEST(Ply, BytesLeftOverAreAnError) {
  const TestFolder folder;
  WritePly(AllTypes(), folder / "a.ply");
  WriteFileAtomically(folder / "a.ply", ReadFile(folder / "a.ply") + "xy");
  ExpectError([&] { ReadPly(folder / "a.ply"); }, {"a.ply: byte ", "2 bytes more"});
}

TEST(Ply, WhatCannotBeWrittenLeavesTheOldFile) {
  const TestFolder folder;
  WriteFileAtomically(folder / "a.ply", "old");
  PlyData data = AllTypes();
  data.elements[0].scalars[1].values[2] = 256;
  ExpectError([&] { WritePly(data, folder / "a.ply"); }, {"a.ply", "property b", "uchar"});
  data = AllTypes();
  data.elements[0].scalars[0].values[1] = 0.5;
  ExpectError([&] { WritePly(data, folder / "a.ply"); }, {"property a"});
  data = AllTypes();
  data.elements[0].scalars[0].values.pop_back();
  ExpectError([&] { WritePly(data, folder / "a.ply"); }, {"property a", "2 values for 3 rows"});
  data = AllTypes();
  data.elements[0].lists[0].items.pop_back();
  ExpectError([&] { WritePly(data, folder / "a.ply"); }, {"list items"});
  data = AllTypes();
  data.comments[0] = "x\nend_header";
  ExpectError([&] { WritePly(data, folder / "a.ply"); }, {"one line"});
  EXPECT_EQ(ReadFile(folder / "a.ply"), "old");
}

TEST(Ply, AMissingFileIsNamed) {
  ExpectError([] { ReadPly("/nowhere/a.ply"); }, {"/nowhere/a.ply"});
}

}  // namespace
}  // namespace colmap_ext
