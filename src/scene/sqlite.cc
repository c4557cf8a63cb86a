#include "scene/sqlite.h"

#include <sqlite3.h>

#include <utility>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace fs = std::filesystem;
namespace {

constexpr int kBusyTimeoutMs = 3000;

// What a person can do about an error of SQLite.
std::string AdviceFor(int code) {
  switch (code & 0xff) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "; the database is truncated or corrupt: restore a copy, or remove it and extract "
             "features again";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "; another program uses the database: close it (COLMAP's GUI?) and try again";
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
      return "; check the permissions of the file and its folder";
    case SQLITE_FULL:
      return "; make room on the disk";
    default:
      return "";
  }
}

// file: URI, in which SQLite takes flags.
std::string UriOf(const fs::path& path, const std::string& query) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string uri = "file:";
  for (const char c : fs::absolute(path).string()) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '/' || c == '.' || c == '-' || c == '_';
    if (is_plain) {
      uri += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      uri += '%';
      uri += kHex[byte >> 4];
      uri += kHex[byte & 15];
    }
  }
  return uri + query;
}

bool HasContent(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  return !error && size > 0;
}

}  // namespace

bool HasPendingJournal(const fs::path& path) {
  return HasContent(path.string() + "-wal") || HasContent(path.string() + "-journal");
}

SqliteConnection::SqliteConnection(fs::path path, Mode mode) : path_(std::move(path)) {
  int flags = SQLITE_OPEN_URI;
  std::string query;
  switch (mode) {
    case Mode::kReadOnly:
      flags |= SQLITE_OPEN_READONLY;
      // A read-only connection would still leave -wal and -shm files beside a database in WAL mode
      // (all of COLMAP's), and fail in a folder that cannot be written to. Without a pending
      // journal nobody is writing, and the file may be read as it is.
      if (!HasPendingJournal(path_)) query = "?immutable=1";
      break;
    case Mode::kReadWrite:
      flags |= SQLITE_OPEN_READWRITE;
      break;
    case Mode::kCreate:
      flags |= SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
      break;
  }
  if (sqlite3_open_v2(UriOf(path_, query).c_str(), &handle_, flags, nullptr) != SQLITE_OK) {
    const std::string reason = handle_ == nullptr ? "out of memory" : sqlite3_errmsg(handle_);
    const int code = handle_ == nullptr ? SQLITE_NOMEM : sqlite3_errcode(handle_);
    sqlite3_close(handle_);
    throw Error(path_.string() + ": cannot open the database: " + reason + AdviceFor(code));
  }
  sqlite3_busy_timeout(handle_, kBusyTimeoutMs);
}

SqliteConnection::~SqliteConnection() { sqlite3_close(handle_); }

void SqliteConnection::Execute(const std::string& sql, const std::string& doing) {
  if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) Fail(doing);
}

void SqliteConnection::CopyTo(SqliteConnection& target) {
  sqlite3_backup* backup = sqlite3_backup_init(target.handle_, "main", handle_, "main");
  if (backup == nullptr) target.Fail("copy the database");
  sqlite3_backup_step(backup, -1);
  if (sqlite3_backup_finish(backup) != SQLITE_OK) target.Fail("copy the database");
}

bool SqliteConnection::IsReadOnly() const { return sqlite3_db_readonly(handle_, "main") == 1; }

void SqliteConnection::Fail(const std::string& doing) const {
  throw Error(path_.string() + ": cannot " + doing + ": " + sqlite3_errmsg(handle_) +
              AdviceFor(sqlite3_errcode(handle_)));
}

void SqliteConnection::FailWith(const std::string& problem) const {
  throw Error(path_.string() + ": " + problem);
}

SqliteStatement::SqliteStatement(const SqliteConnection& connection, const std::string& sql,
                                 std::string doing)
    : connection_(connection), doing_(std::move(doing)) {
  if (sqlite3_prepare_v2(connection.handle(), sql.c_str(), -1, &handle_, nullptr) != SQLITE_OK) {
    connection_.Fail(doing_);
  }
}

SqliteStatement::~SqliteStatement() { sqlite3_finalize(handle_); }

void SqliteStatement::CheckBound(int code) {
  if (code != SQLITE_OK) connection_.Fail(doing_);
}

SqliteStatement& SqliteStatement::Bind(std::int64_t value) {
  CheckBound(sqlite3_bind_int64(handle_, ++num_bound_, value));
  return *this;
}

SqliteStatement& SqliteStatement::Bind(double value) {
  CheckBound(sqlite3_bind_double(handle_, ++num_bound_, value));
  return *this;
}

SqliteStatement& SqliteStatement::Bind(const std::string& value) {
  CheckBound(sqlite3_bind_text64(handle_, ++num_bound_, value.data(), value.size(),
                                 SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

SqliteStatement& SqliteStatement::BindBlob(const void* data, std::size_t num_bytes) {
  // A null pointer would become NULL instead of an empty blob.
  CheckBound(num_bytes == 0
                 ? sqlite3_bind_zeroblob(handle_, ++num_bound_, 0)
                 : sqlite3_bind_blob64(handle_, ++num_bound_, data, num_bytes, SQLITE_STATIC));
  return *this;
}

SqliteStatement& SqliteStatement::BindNull() {
  CheckBound(sqlite3_bind_null(handle_, ++num_bound_));
  return *this;
}

bool SqliteStatement::Step() {
  switch (sqlite3_step(handle_)) {
    case SQLITE_ROW:
      return true;
    case SQLITE_DONE:
      return false;
    default:
      connection_.Fail(doing_);
  }
}

bool SqliteStatement::IsNull(int column) const {
  return sqlite3_column_type(handle_, column) == SQLITE_NULL;
}

std::int64_t SqliteStatement::Integer(int column) const {
  if (sqlite3_column_type(handle_, column) != SQLITE_INTEGER) {
    FailWith(std::string("column ") + sqlite3_column_name(handle_, column) +
             " holds no whole number; the database is corrupt");
  }
  return sqlite3_column_int64(handle_, column);
}

std::int64_t SqliteStatement::Integer(int column, std::int64_t min, std::int64_t max) const {
  const std::int64_t value = Integer(column);
  if (value < min || value > max) {
    FailWith(std::string("column ") + sqlite3_column_name(handle_, column) + " holds " +
             std::to_string(value) + ", not " + std::to_string(min) + " to " + std::to_string(max) +
             "; the database is corrupt");
  }
  return value;
}

double SqliteStatement::Real(int column) const {
  const int type = sqlite3_column_type(handle_, column);
  if (type != SQLITE_FLOAT && type != SQLITE_INTEGER) {
    FailWith(std::string("column ") + sqlite3_column_name(handle_, column) +
             " holds no number; the database is corrupt");
  }
  return sqlite3_column_double(handle_, column);
}

std::string SqliteStatement::Text(int column) const {
  const unsigned char* text = sqlite3_column_text(handle_, column);
  if (text == nullptr) {
    FailWith(std::string("column ") + sqlite3_column_name(handle_, column) +
             " holds no text; the database is corrupt");
  }
  return {reinterpret_cast<const char*>(text),
          static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

std::span<const std::byte> SqliteStatement::Blob(int column) const {
  const void* data = sqlite3_column_blob(handle_, column);
  const int num_bytes = sqlite3_column_bytes(handle_, column);
  if (data == nullptr) return {};
  return {static_cast<const std::byte*>(data), static_cast<std::size_t>(num_bytes)};
}

}  // namespace colmap_ext
