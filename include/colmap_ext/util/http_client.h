// One HTTP/1.1 request and its answer (Boost.Beast), never for longer than it may take.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace colmap_ext {

struct HttpCallOptions {
  double connect_timeout_s = 5;
  double silence_timeout_s = 10;  // the server sends nothing for so long
  double total_timeout_s = 180;
  std::size_t max_bytes = std::size_t{200} << 20;  // of the answer's body
  std::string Check() const;
};

struct HttpCall {
  std::string host;  // name or address
  std::string port = "80";
  std::string method = "GET";
  std::string target = "/";
  std::string body;                                               // sent as JSON when there is one
  std::vector<std::pair<std::string, std::string>> headers = {};  // further ones
};

struct HttpReply {
  int status = 0;
  std::string reason;  // "Not Found"
  std::string body;
};

// Blocks: for a worker. Throws Error, without the address, when the server cannot be reached, falls
// silent, answers no HTTP, or sends fewer bytes than it announced or more than allowed.
// Redirections are not followed.
HttpReply CallHttp(const HttpCall& call, const HttpCallOptions& options);

}  // namespace colmap_ext
