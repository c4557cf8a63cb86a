// What comes over HTTP on this machine: calls of the flight daemon and of the page.
#include <array>
#include <filesystem>
#include <string>

#include "colmap_ext/util/error.h"
#include "flight/api_call.h"
#include "fuzz/targets.h"
#include "report/page_requests.h"

namespace colmap_ext {
namespace {

// Parts of the input, between zeros.
template <std::size_t n>
std::array<std::string, n> PartsOf(std::span<const std::uint8_t> bytes) {
  std::array<std::string, n> parts;
  std::size_t part = 0;
  for (const std::uint8_t byte : bytes) {
    if (byte == 0 && part + 1 < n) {
      ++part;
    } else {
      parts[part] += static_cast<char>(byte);
    }
  }
  return parts;
}

}  // namespace

void FuzzDaemonApi(std::span<const std::uint8_t> bytes) {
  const auto [method, target, host, origin, authorization, body] = PartsOf<6>(bytes);
  const std::string token = "token";
  try {
    ParseApiCall({method, target, host, origin, authorization, body}, token, {});
    Promise(authorization == "Bearer " + token, "nothing is done without the token");
    Promise(origin.empty(), "nothing is done for a web page");
  } catch (const ApiError& error) {
    Promise(error.status() >= 400 && error.status() < 500, "a refusal is the caller's fault");
  }
}

void FuzzPageRequests(std::span<const std::uint8_t> bytes) {
  static const LiveState live;
  const PageContext context{
      std::filesystem::temp_directory_path() / "no_such_report", "", "title", 8080, "token", &live};
  const auto [method, target, host, origin, token, body] = PartsOf<6>(bytes);
  const PageAnswer answer = AnswerPageRequest({method, target, host, origin, token, body}, context);
  Promise(!answer.call || answer.call->method == "GET" || token == "token",
          "only the page itself moves the vehicle");
  Promise(answer.status == 200 || (answer.status >= 400 && answer.status <= 500),
          "an answer or a refusal");
}

}  // namespace colmap_ext
