// SQLite with RAII and errors that name the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace colmap_ext {

// Whether a -wal or -journal file beside the database holds changes that are not in it yet.
bool HasPendingJournal(const std::filesystem::path& path);

// An open database file.
class SqliteConnection {
 public:
  enum class Mode { kReadOnly, kReadWrite, kCreate };

  SqliteConnection(std::filesystem::path path, Mode mode);
  ~SqliteConnection();
  SqliteConnection(const SqliteConnection&) = delete;
  SqliteConnection& operator=(const SqliteConnection&) = delete;

  // Runs statements that return nothing. `doing` completes "cannot …" in the error.
  void Execute(const std::string& sql, const std::string& doing);
  // Makes a copy of the committed content in `target`, which must be empty.
  void CopyTo(SqliteConnection& target);

  // Throws Error for SQLite's present error code.
  [[noreturn]] void Fail(const std::string& doing) const;
  // Throws Error "<file>: <problem>".
  [[noreturn]] void FailWith(const std::string& problem) const;

  bool IsReadOnly() const;
  const std::filesystem::path& path() const { return path_; }
  sqlite3* handle() const { return handle_; }

 private:
  std::filesystem::path path_;
  sqlite3* handle_ = nullptr;
};

// A prepared statement. Parameters and columns are numbered from 0.
class SqliteStatement {
 public:
  // `connection` must outlive this object.
  SqliteStatement(const SqliteConnection& connection, const std::string& sql, std::string doing);
  ~SqliteStatement();
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  SqliteStatement& Bind(std::int64_t value);
  SqliteStatement& Bind(double value);
  SqliteStatement& Bind(const std::string& value);
  // Not copied: must stay until Step.
  SqliteStatement& BindBlob(const void* data, std::size_t num_bytes);
  SqliteStatement& BindNull();

  // Moves to the next row; false after the last. Throws Error when SQLite fails.
  bool Step();

  bool IsNull(int column) const;
  // Throw Error when the column has no such value.
  std::int64_t Integer(int column) const;
  // Within [min, max].
  std::int64_t Integer(int column, std::int64_t min, std::int64_t max) const;
  double Real(int column) const;
  std::string Text(int column) const;
  // Empty for NULL. Valid until the next Step.
  std::span<const std::byte> Blob(int column) const;

  // Throws Error "<file>: <problem>".
  [[noreturn]] void FailWith(const std::string& problem) const { connection_.FailWith(problem); }

 private:
  void CheckBound(int code);

  const SqliteConnection& connection_;
  std::string doing_;
  sqlite3_stmt* handle_ = nullptr;
  int num_bound_ = 0;
};

}  // namespace colmap_ext
