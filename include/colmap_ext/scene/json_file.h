// JSON files with errors that say where: file and JSON pointer.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace colmap_ext {

// Keeps its keys in the order in which they were set.
using Json = nlohmann::ordered_json;

// Throws Error naming the file, and line and column where it is no JSON.
Json ReadJsonFile(const std::filesystem::path& path);

// Atomic, indented, ends with a line end. Numbers get the shortest digits that read back to the
// same double. Throws Error naming file and JSON pointer of a number that is not finite (JSON has
// none).
void WriteJsonFile(const Json& json, const std::filesystem::path& path);

// A place in a JSON file; every accessor throws Error naming the file, the JSON pointer of the
// place and what was expected there. The Json must outlive it.
class JsonNode {
 public:
  JsonNode(const Json& json, std::filesystem::path path)
      : JsonNode(json, std::move(path), std::string()) {}

  JsonNode operator[](const std::string& key) const;  // of an object; the key must be there
  std::optional<JsonNode> Find(const std::string& key) const;  // of an object; nullopt: no such key
  std::vector<JsonNode> Items() const;                         // of an array

  bool IsNull() const;
  double Number() const;
  int Integer() const;
  bool Boolean() const;
  std::string Text() const;
  Eigen::Vector3d Vector() const;  // [x, y, z]

  [[noreturn]] void Fail(const std::string& message) const;

 private:
  JsonNode(const Json& json, std::filesystem::path path, std::string pointer)
      : json_(&json), path_(std::move(path)), pointer_(std::move(pointer)) {}

  const Json* json_;
  std::filesystem::path path_;
  std::string pointer_;
};

}  // namespace colmap_ext
