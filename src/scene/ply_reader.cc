#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "colmap_ext/scene/ply.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/ply_types.h"
#include "scene/text_numbers.h"

namespace colmap_ext {
namespace {

// A property in the order of the file; rows of a file may mix scalars and lists.
struct PropertySlot {
  bool is_list = false;
  std::size_t index = 0;  // in scalars or lists
};

class PlyParser {
 public:
  PlyParser(const std::string& bytes, const std::filesystem::path& path)
      : bytes_(bytes), path_(path) {}

  PlyData Parse() {
    ParseHeader();
    for (std::size_t i = 0; i < data_.elements.size(); ++i) {
      CheckRowsFit(data_.elements[i], slots_[i]);
      if (is_ascii_) {
        ParseAsciiRows(slots_[i], &data_.elements[i]);
      } else {
        ParseBinaryRows(slots_[i], &data_.elements[i]);
      }
    }
    CheckNothingLeft();
    return std::move(data_);
  }

 private:
  [[noreturn]] void FailAtLine(const std::string& message) const {
    throw Error(path_.string() + ": line " + std::to_string(line_) + ": " + message);
  }
  [[noreturn]] void FailAtByte(const std::string& message) const {
    throw Error(path_.string() + ": byte " + std::to_string(offset_) + ": " + message);
  }

  std::size_t BytesLeft() const { return bytes_.size() - offset_; }

  // ---- header ----

  std::string_view NextHeaderLine() {
    ++line_;
    const auto line = NextLine(bytes_, &offset_);
    if (!line) FailAtLine("the header has no end_header; the file is truncated or no PLY file");
    return *line;
  }

  void ParseHeader() {
    if (NextHeaderLine() != "ply") {
      FailAtLine("this is no PLY file (it does not start with the word ply)");
    }
    bool has_format = false;
    while (true) {
      const std::string_view line = NextHeaderLine();
      const auto words = SplitWords(line);
      if (words.empty()) continue;
      if (words[0] == "end_header") break;
      if (words[0] == "comment") {
        data_.comments.emplace_back(line.substr(std::min(line.size(), line.find("comment") + 8)));
      } else if (words[0] == "format") {
        ParseFormat(words);
        has_format = true;
      } else if (words[0] == "element") {
        ParseElement(words);
      } else if (words[0] == "property") {
        ParseProperty(words);
      } else if (words[0] != "obj_info") {
        FailAtLine("unknown header word '" + std::string(words[0].substr(0, 40)) + "'");
      }
    }
    if (!has_format) FailAtLine("the header has no format line");
  }

  void ParseFormat(const std::vector<std::string_view>& words) {
    if (words.size() != 3 || words[2] != "1.0") FailAtLine("expected 'format <kind> 1.0'");
    if (words[1] != "ascii" && words[1] != "binary_little_endian") {
      FailAtLine("format " + std::string(words[1].substr(0, 40)) +
                 " is not supported; save the file as binary_little_endian or ascii");
    }
    is_ascii_ = words[1] == "ascii";
  }

  void ParseElement(const std::vector<std::string_view>& words) {
    const auto count = words.size() == 3 ? ParseNumber(words[2]) : std::nullopt;
    if (!count || !(*count >= 0) || *count > 1e15 || *count != std::floor(*count)) {
      FailAtLine("expected 'element <name> <number of rows>'");
    }
    if (data_.FindElement(words[1]) != nullptr) {
      FailAtLine("element " + std::string(words[1]) + " is declared twice");
    }
    PlyElement element;
    element.name = words[1];
    element.count = static_cast<std::size_t>(*count);
    data_.elements.push_back(std::move(element));
    slots_.emplace_back();
  }

  PlyType TypeFromWord(std::string_view word) const {
    const auto type = PlyTypeFromName(word);
    if (!type) FailAtLine("unknown number type '" + std::string(word.substr(0, 40)) + "'");
    return *type;
  }

  void ParseProperty(const std::vector<std::string_view>& words) {
    if (data_.elements.empty()) FailAtLine("a property before the first element");
    PlyElement& element = data_.elements.back();
    const bool is_list = words.size() == 5 && words[1] == "list";
    if (!is_list && words.size() != 3) {
      FailAtLine("expected 'property <type> <name>' or 'property list <type> <type> <name>'");
    }
    const std::string name(words.back());
    if (element.FindScalar(name) != nullptr || element.FindList(name) != nullptr) {
      FailAtLine("property " + name + " is declared twice");
    }
    if (is_list) {
      PlyList list;
      list.name = name;
      list.count_type = TypeFromWord(words[2]);
      list.item_type = TypeFromWord(words[3]);
      if (!IsPlyInteger(list.count_type))
        FailAtLine("the length of a list must be an integer type");
      slots_.back().push_back({true, element.lists.size()});
      element.lists.push_back(std::move(list));
    } else {
      slots_.back().push_back({false, element.scalars.size()});
      element.scalars.push_back({.name = name, .type = TypeFromWord(words[1]), .values = {}});
    }
  }

  // ---- rows ----

  // Refuses a header that promises more rows than the rest of the file can hold, so that memory
  // follows the size of the file.
  void CheckRowsFit(const PlyElement& element, const std::vector<PropertySlot>& slots) const {
    if (element.count == 0) return;
    std::size_t min_row_bytes = 0;
    for (const PropertySlot& slot : slots) {
      if (is_ascii_) {
        min_row_bytes += 2;  // a digit and what separates it from the next
      } else if (slot.is_list) {
        min_row_bytes += PlySize(element.lists[slot.index].count_type);
      } else {
        min_row_bytes += PlySize(element.scalars[slot.index].type);
      }
    }
    const std::string what =
        "element " + element.name + " of " + std::to_string(element.count) + " rows";
    if (min_row_bytes == 0) throw Error(path_.string() + ": " + what + " has no properties");
    // The last line of a text may lack its line end.
    const std::size_t room = BytesLeft() + (is_ascii_ ? 1 : 0);
    if (element.count > room / min_row_bytes) {
      const std::string message = what + " does not fit into the rest of the file (" +
                                  std::to_string(BytesLeft()) +
                                  " bytes); it is truncated or corrupt";
      if (is_ascii_) FailAtLine(message);
      FailAtByte(message);
    }
  }

  static void Reserve(PlyElement* element) {
    for (PlyScalar& scalar : element->scalars) scalar.values.reserve(element->count);
    for (PlyList& list : element->lists) list.starts.reserve(element->count + 1);
  }

  void ParseBinaryRows(const std::vector<PropertySlot>& slots, PlyElement* element) {
    Reserve(element);
    for (std::size_t row = 0; row < element->count; ++row) {
      for (const PropertySlot& slot : slots) {
        if (slot.is_list) {
          ParseBinaryList(&element->lists[slot.index]);
        } else {
          PlyScalar& scalar = element->scalars[slot.index];
          scalar.values.push_back(NextBinary(scalar.type));
        }
      }
    }
  }

  double NextBinary(PlyType type) {
    if (PlySize(type) > BytesLeft()) FailAtByte("the file ends inside its data; it is truncated");
    const double value = LoadPlyNumber(bytes_.data() + offset_, type);
    offset_ += PlySize(type);
    return value;
  }

  void ParseBinaryList(PlyList* list) {
    const double count = NextBinary(list->count_type);
    if (count < 0 || count > static_cast<double>(BytesLeft() / PlySize(list->item_type))) {
      FailAtByte("a list of " + std::to_string(static_cast<long long>(count)) +
                 " items does not fit into the rest of the file; it is truncated or corrupt");
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      list->items.push_back(NextBinary(list->item_type));
    }
    list->starts.push_back(list->items.size());
  }

  void ParseAsciiRows(const std::vector<PropertySlot>& slots, PlyElement* element) {
    Reserve(element);
    for (std::size_t row = 0; row < element->count; ++row) {
      words_ = NextAsciiRow(*element, row);
      next_word_ = 0;
      for (const PropertySlot& slot : slots) {
        if (slot.is_list) {
          ParseAsciiList(&element->lists[slot.index]);
        } else {
          PlyScalar& scalar = element->scalars[slot.index];
          scalar.values.push_back(NextAscii(scalar.type, scalar.name));
        }
      }
      if (next_word_ != words_.size()) {
        FailAtLine(std::to_string(words_.size()) + " values where " + std::to_string(next_word_) +
                   " were expected");
      }
    }
  }

  std::vector<std::string_view> NextAsciiRow(const PlyElement& element, std::size_t row) {
    while (true) {
      ++line_;
      const auto line = NextLine(bytes_, &offset_);
      if (!line) {
        FailAtLine("the file ends after " + std::to_string(row) + " of " +
                   std::to_string(element.count) + " rows of element " + element.name);
      }
      auto words = SplitWords(*line);
      if (!words.empty()) return words;
    }
  }

  double NextAscii(PlyType type, const std::string& name) {
    if (next_word_ == words_.size()) FailAtLine("the value of " + name + " is missing");
    const std::string_view word = words_[next_word_++];
    const auto value = ParseNumber(word);
    if (!value || !FitsPlyType(*value, type)) {
      FailAtLine("'" + std::string(word.substr(0, 40)) + "' is no value for " + name + " (" +
                 PlyName(type) + ")");
    }
    return *value;
  }

  void ParseAsciiList(PlyList* list) {
    const double count = NextAscii(list->count_type, "the length of " + list->name);
    if (count < 0) FailAtLine("the length of " + list->name + " is negative");
    for (double i = 0; i < count; ++i)
      list->items.push_back(NextAscii(list->item_type, list->name));
    list->starts.push_back(list->items.size());
  }

  void CheckNothingLeft() {
    if (!is_ascii_) {
      if (BytesLeft() == 0) return;
      FailAtByte(std::to_string(BytesLeft()) + " bytes more than the header announces");
    }
    while (const auto line = NextLine(bytes_, &offset_)) {
      ++line_;
      if (!SplitWords(*line).empty()) FailAtLine("more rows than the header announces");
    }
  }

  const std::string& bytes_;
  const std::filesystem::path& path_;
  PlyData data_;
  std::vector<std::vector<PropertySlot>> slots_;  // one an element
  bool is_ascii_ = true;
  std::size_t offset_ = 0;
  std::size_t line_ = 0;  // the line last read
  std::vector<std::string_view> words_;
  std::size_t next_word_ = 0;
};

template <typename T>
const T* FindByName(const std::vector<T>& things, std::string_view name) {
  const auto it = std::find_if(things.begin(), things.end(),
                               [&](const T& thing) { return thing.name == name; });
  return it == things.end() ? nullptr : &*it;
}

}  // namespace

const PlyScalar* PlyElement::FindScalar(std::string_view scalar_name) const {
  return FindByName(scalars, scalar_name);
}

const PlyList* PlyElement::FindList(std::string_view list_name) const {
  return FindByName(lists, list_name);
}

const PlyElement* PlyData::FindElement(std::string_view name) const {
  return FindByName(elements, name);
}

PlyData ReadPly(const std::filesystem::path& path) {
  const std::string bytes = ReadFile(path);
  return PlyParser(bytes, path).Parse();
}

}  // namespace colmap_ext
