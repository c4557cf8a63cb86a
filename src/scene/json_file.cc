#include "colmap_ext/scene/json_file.h"

#include <cmath>
#include <limits>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

std::string ChildPointer(const std::string& pointer, const std::string& key) {
  // RFC 6901: '~' and '/' inside a key.
  std::string escaped;
  for (const char c : key) {
    if (c == '~') {
      escaped += "~0";
    } else if (c == '/') {
      escaped += "~1";
    } else {
      escaped += c;
    }
  }
  return pointer + "/" + escaped;
}

void CheckFinite(const Json& json, const std::string& pointer, const std::string& path) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) {
    throw Error(path + ": " + pointer + ": the number is not finite, so JSON cannot hold it");
  }
  if (json.is_object()) {
    for (const auto& [key, value] : json.items())
      CheckFinite(value, ChildPointer(pointer, key), path);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) {
      CheckFinite(json[i], ChildPointer(pointer, std::to_string(i)), path);
    }
  }
}

}  // namespace

Json ReadJsonFile(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  try {
    return Json::parse(text);
  } catch (const nlohmann::json::exception& e) {
    std::string message = e.what();  // "[json.exception.…] parse error at line 1, column 2: …"
    const auto end_of_id = message.find("] ");
    if (end_of_id != std::string::npos) message = message.substr(end_of_id + 2);
    throw Error(path.string() + ": not valid JSON: " + message);
  }
}

void WriteJsonFile(const Json& json, const std::filesystem::path& path) {
  CheckFinite(json, "", path.string());
  std::string text;
  try {
    text = json.dump(1) + "\n";
  } catch (const nlohmann::json::exception& e) {  // text that is not UTF-8
    throw Error(path.string() + ": cannot be written as JSON: " + e.what());
  }
  WriteFileAtomically(path, text);
}

void JsonNode::Fail(const std::string& message) const {
  throw Error(path_.string() + ": " + (pointer_.empty() ? "top level" : pointer_) + ": " + message);
}

JsonNode JsonNode::operator[](const std::string& key) const {
  if (const auto child = Find(key)) return *child;
  Fail("\"" + key + "\" is missing");
}

std::optional<JsonNode> JsonNode::Find(const std::string& key) const {
  if (!json_->is_object()) Fail("expected an object, found " + std::string(json_->type_name()));
  const auto it = json_->find(key);
  if (it == json_->end()) return std::nullopt;
  return JsonNode(*it, path_, ChildPointer(pointer_, key));
}

std::vector<JsonNode> JsonNode::Items() const {
  if (!json_->is_array()) Fail("expected an array, found " + std::string(json_->type_name()));
  std::vector<JsonNode> items;
  items.reserve(json_->size());
  for (std::size_t i = 0; i < json_->size(); ++i) {
    items.push_back(JsonNode((*json_)[i], path_, ChildPointer(pointer_, std::to_string(i))));
  }
  return items;
}

bool JsonNode::IsNull() const { return json_->is_null(); }

double JsonNode::Number() const {
  if (!json_->is_number()) Fail("expected a number, found " + std::string(json_->type_name()));
  const double value = json_->get<double>();
  if (!std::isfinite(value)) Fail("the number is too large");
  return value;
}

int JsonNode::Integer() const {
  const double value = Number();
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    Fail("expected a whole number");
  }
  return static_cast<int>(value);
}

bool JsonNode::Boolean() const {
  if (!json_->is_boolean())
    Fail("expected true or false, found " + std::string(json_->type_name()));
  return json_->get<bool>();
}

std::string JsonNode::Text() const {
  if (!json_->is_string()) Fail("expected a text, found " + std::string(json_->type_name()));
  return json_->get<std::string>();
}

Eigen::Vector3d JsonNode::Vector() const {
  const auto items = Items();
  if (items.size() != 3) Fail("expected three numbers [x, y, z]");
  return {items[0].Number(), items[1].Number(), items[2].Number()};
}

}  // namespace colmap_ext
