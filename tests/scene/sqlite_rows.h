// What a statement gives, read by SQLite itself.
#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>
#include <vector>

namespace colmap_ext {

// One text a row, its values with | between; NULL for no value.
inline std::vector<std::string> Query(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* handle = nullptr;
  EXPECT_EQ(sqlite3_open(path.c_str(), &handle), SQLITE_OK);
  std::vector<std::string> rows;
  const auto collect = [](void* pointer, int count, char** values, char**) {
    std::string row;
    for (int i = 0; i < count; ++i) {
      row += std::string(i == 0 ? "" : "|") + (values[i] != nullptr ? values[i] : "NULL");
    }
    static_cast<std::vector<std::string>*>(pointer)->push_back(row);
    return 0;
  };
  EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), collect, &rows, nullptr), SQLITE_OK) << sql;
  sqlite3_close(handle);
  return rows;
}

}  // namespace colmap_ext
