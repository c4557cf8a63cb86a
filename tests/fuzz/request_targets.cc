// What comes over HTTP on this machine: calls of the flight daemon and of the page; and what the
// daemon reads back of its own.
#include <array>
#include <filesystem>
#include <string>

#include "colmap_ext/flight/flight_journal.h"
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

void FuzzFlightJournal(std::span<const std::uint8_t> bytes) {
  const std::string text(bytes.begin(), bytes.end());
  std::size_t whole = 0;
  try {
    const FlightLedger ledger = ReplayJournal(text, "journal", &whole);
    Promise(whole <= text.size(), "no more was read than there is");
    const FlightLedger again = ReplayJournal(text.substr(0, whole), "journal");
    Promise(again.views.size() == ledger.views.size() && again.flights == ledger.flights,
            "a line without end counts for nothing");
  } catch (const Error&) {
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
