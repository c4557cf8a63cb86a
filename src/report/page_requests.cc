#include "report/page_requests.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "report/html_text.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kKeptMessages = 2000;

PageAnswer Refuse(int status, const std::string& reason) {
  return {status, "application/json", Json{{"error", reason}}.dump() + "\n", std::nullopt};
}

const char* NameOf(LogLevel level) {
  constexpr std::array kNames = {"debug", "info", "warning", "error"};
  return kNames[static_cast<std::size_t>(level)];
}

std::string DumpLeniently(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// Names this server has on its machine.
bool IsOwnHost(const std::string& host, int port) {
  const std::string suffix = ":" + std::to_string(port);
  return host == "127.0.0.1" + suffix || host == "localhost" + suffix;
}

// nullopt: a broken escape, or a zero.
std::optional<std::string> DecodePercent(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      unsigned value = 0;
      if (i + 2 >= text.size()) return std::nullopt;
      const auto [end, error] =
          std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16);
      if (error != std::errc() || end != text.data() + i + 3) return std::nullopt;
      c = static_cast<char>(value);
      i += 2;
    }
    if (c == '\0') return std::nullopt;
    decoded += c;
  }
  return decoded;
}

// The file below `folder` that a decoded path names; nullopt when it leaves the folder or any part
// is hidden.
std::optional<fs::path> FileBelow(const fs::path& folder, const std::string& path) {
  fs::path file = folder;
  for (const fs::path& part : fs::path(path).relative_path()) {
    if (part.empty() || part.string().starts_with('.')) return std::nullopt;
    file /= part;
  }
  return file;
}

const char* TypeOf(const fs::path& file) {
  constexpr std::array<std::pair<const char*, const char*>, 7> kTypes = {
      {{".html", "text/html; charset=utf-8"},
       {".js", "text/javascript; charset=utf-8"},
       {".css", "text/css; charset=utf-8"},
       {".json", "application/json"},
       {".jpg", "image/jpeg"},
       {".png", "image/png"},
       {".svg", "image/svg+xml"}}};
  const auto* found = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& type) {
    return file.extension() == type.first;
  });
  return found == kTypes.end() ? "application/octet-stream" : found->second;
}

// A session's page before its first iteration is done.
PageAnswer AnswerWithoutPage(const std::string& path, const PageContext& context) {
  if (path == "/data/session.js") {
    const Json session = {{"title", context.title},
                          {"finished", ""},
                          {"sentence", "The first iteration is not done yet"},
                          {"photo_folder", ""},
                          {"iterations", Json::array()}};
    return {200, TypeOf("a.js"), "colmapExt.put(\"session\", " + DumpLeniently(session) + ");\n",
            std::nullopt};
  }
  for (const auto& [target, name] : {std::pair{"/index.html", "page.html"},
                                     {"/assets/page.js", "page.js"},
                                     {"/assets/page.css", "page.css"}}) {
    if (path != target) continue;
    std::string text = ReadFile(context.assets / name);
    for (const auto& [mark, value] :
         {std::pair<std::string, std::string>{"{{TITLE}}", context.title}, {"{{STATUS}}", ""}}) {
      if (path != "/index.html") break;
      for (auto at = text.find(mark); at != std::string::npos; at = text.find(mark)) {
        text.replace(at, mark.size(), EscapeHtml(value));
      }
    }
    return {200, TypeOf(name), text, std::nullopt};
  }
  return Refuse(404, "the first iteration is not done yet");
}

PageAnswer AnswerFile(const std::string& path, const PageContext& context) {
  const std::string name = path == "/" ? "/index.html" : path;
  const auto file = FileBelow(context.report, name);
  if (!file) return Refuse(403, "no such file");
  std::error_code error;
  if (fs::is_regular_file(*file, error)) {
    return {200, TypeOf(*file), ReadFile(*file), std::nullopt};
  }
  const bool has_page = fs::exists(context.report / "index.html", error);
  if (!has_page && !context.assets.empty()) return AnswerWithoutPage(name, context);
  return Refuse(404, "no such file");
}

// Changes whenever the page's list of iterations was written anew.
std::string VersionOf(const fs::path& report) {
  std::error_code error;
  const auto time = fs::last_write_time(report / "data" / "session.js", error);
  return error ? "0" : std::to_string(time.time_since_epoch().count());
}

PageAnswer AnswerGet(const std::string& path, std::string_view query, const PageContext& context) {
  if (path == "/api/live" || path == "/api/events") {
    std::size_t since = 0;
    constexpr std::string_view kSince = "since=";
    if (query.starts_with(kSince)) {
      std::from_chars(query.data() + kSince.size(), query.data() + query.size(), since);
    }
    if (path == "/api/events") return {200, "text/event-stream", "", std::nullopt, since};
    return {200, "application/json",
            context.live->ToJson(since, context.token, VersionOf(context.report)), std::nullopt};
  }
  if (path == "/api/flight") {
    return {200, "application/json", "", DaemonCall{"GET", "/v1/status", ""}};
  }
  if (path.starts_with("/api/")) return Refuse(404, "no such call");
  return AnswerFile(path, context);
}

PageAnswer AnswerPost(const std::string& path, const PageRequest& request,
                      const PageContext& context) {
  if (request.token.empty() || request.token != context.token) {
    return Refuse(403, "the page's token is missing or old; load the page again");
  }
  if (path == "/api/flight/pause" || path == "/api/flight/resume") {
    return {200, "", "", DaemonCall{"POST", "/v1/" + path.substr(12), ""}};
  }
  if (path == "/api/flight/abort") {
    const Json body = Json::parse(request.body, nullptr, false);
    const bool has_how = body.is_object() && body.contains("how") && body["how"].is_string();
    const std::string how = has_how ? body["how"].get<std::string>() : "";
    if (how != "rtl" && how != "land") return Refuse(400, "abort needs \"how\": rtl or land");
    return {200, "", "", DaemonCall{"POST", "/v1/abort", Json{{"how", how}}.dump()}};
  }
  return Refuse(404, "no such call");
}

}  // namespace

void LiveState::Message(LogLevel level, std::string_view text) {
  const std::lock_guard lock(mutex_);
  messages_.push_back({level, std::string(text)});
  if (messages_.size() > kKeptMessages) {
    messages_.pop_front();
    ++first_;
  }
}

void LiveState::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  const std::lock_guard lock(mutex_);
  stage_ = stage;
  done_ = done;
  total_ = total;
}

void LiveState::Finish() {
  const std::lock_guard lock(mutex_);
  is_running_ = false;
}

std::string LiveState::ToJson(std::size_t since, const std::string& token,
                              const std::string& version) const {
  const std::lock_guard lock(mutex_);
  const std::size_t next = first_ + messages_.size();
  Json messages = Json::array();
  for (std::size_t n = std::max(since, first_); n < next; ++n) {
    const Entry& entry = messages_[n - first_];
    messages.push_back({{"level", NameOf(entry.level)}, {"text", entry.text}});
  }
  return DumpLeniently({{"running", is_running_},
                        {"stage", stage_},
                        {"done", done_},
                        {"total", total_},
                        {"version", version},
                        {"token", token},
                        {"next", next},
                        {"messages", messages}});
}

std::string LiveEvents::Next() {
  const std::string text =
      context_->live->ToJson(next_, context_->token, VersionOf(context_->report));
  if (text == last_) return "";
  const Json json = Json::parse(text);
  next_ = json["next"];
  // What the next call would say if nothing happened until then.
  Json quiet = json;
  quiet["messages"] = Json::array();
  last_ = DumpLeniently(quiet);
  return "data: " + text + "\n\n";
}

PageAnswer AnswerPageRequest(const PageRequest& request, const PageContext& context) {
  if (!IsOwnHost(request.host, context.port)) return Refuse(403, "this server has another name");
  if (!request.origin.empty() && request.origin != "http://" + request.host) {
    return Refuse(403, "requests of other web pages are refused");
  }
  const std::size_t mark = request.target.find('?');
  const auto path = DecodePercent(request.target.substr(0, mark));
  if (!path || !path->starts_with('/')) return Refuse(400, "not a path");
  const std::string_view query = mark == std::string::npos
                                     ? std::string_view()
                                     : std::string_view(request.target).substr(mark + 1);
  try {
    if (request.method == "GET") return AnswerGet(*path, query, context);
    if (request.method == "POST") return AnswerPost(*path, request, context);
  } catch (const Error& error) {
    return Refuse(500, error.what());
  }
  return Refuse(405, "only GET and POST");
}

}  // namespace colmap_ext
