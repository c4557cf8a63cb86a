#pragma once

#include <string>
#include <vector>

namespace colmap_ext {

// Indented XML with escaped text. Elements must be closed in the order of stacks.
class XmlWriter {
 public:
  XmlWriter() : text_("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n") {}

  // `attributes`: as they are written, with a leading space.
  void Open(const std::string& name, const std::string& attributes = "") {
    text_ += Indent() + "<" + name + attributes + ">\n";
    open_.push_back(name);
  }
  void Close() {
    const std::string name = open_.back();
    open_.pop_back();
    text_ += Indent() + "</" + name + ">\n";
  }
  void Leaf(const std::string& name, const std::string& value) {
    text_ += Indent() + "<" + name + ">" + Escaped(value) + "</" + name + ">\n";
  }
  void Leaf(const std::string& name, int value) { Leaf(name, std::to_string(value)); }

  const std::string& text() const { return text_; }

 private:
  std::string Indent() const { return std::string(2 * open_.size(), ' '); }
  static std::string Escaped(const std::string& value) {
    std::string escaped;
    for (const char c : value) {
      if (c == '&') {
        escaped += "&amp;";
      } else if (c == '<') {
        escaped += "&lt;";
      } else if (c == '>') {
        escaped += "&gt;";
      } else {
        escaped += c;
      }
    }
    return escaped;
  }

  std::string text_;
  std::vector<std::string> open_;
};

}  // namespace colmap_ext
