#include "colmap_ext/mavlink/signing.h"

#include <openssl/crypto.h>
#include <openssl/sha.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "colmap_ext/mavlink/messages.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

constexpr double kUnitsPerSecond = 1e5;
constexpr double kUnixSecondsOf2015 = 1420070400;
constexpr std::uint64_t kGreatestTimestamp = (std::uint64_t{1} << 48U) - 1;
constexpr double kOldestNewStreamS = 60;

std::array<std::uint8_t, 6> HashOf(const MavFrame& frame, const MavSigningKey& key) {
  std::vector<std::uint8_t> text(key.begin(), key.end());
  const std::vector<std::uint8_t> bytes = MavFrameBytes(frame);
  text.insert(text.end(), bytes.begin(), bytes.end() - 6);
  std::array<std::uint8_t, SHA256_DIGEST_LENGTH> digest;
  SHA256(text.data(), text.size(), digest.data());
  std::array<std::uint8_t, 6> hash;
  std::copy_n(digest.begin(), hash.size(), hash.begin());
  return hash;
}

int HexDigit(char letter) {
  if (letter >= '0' && letter <= '9') return letter - '0';
  const int lower = std::tolower(static_cast<unsigned char>(letter));
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

bool ParseHexKey(std::string text, MavSigningKey* key) {
  const char* const kSpace = " \t\r\n";
  text.erase(0, text.find_first_not_of(kSpace));
  text.erase(text.find_last_not_of(kSpace) + 1);
  if (text.size() != 2 * key->size()) return false;
  for (std::size_t i = 0; i < key->size(); ++i) {
    const int high = HexDigit(text[2 * i]);
    const int low = HexDigit(text[2 * i + 1]);
    if (high < 0 || low < 0) return false;
    (*key)[i] = static_cast<std::uint8_t>(high << 4 | low);
  }
  return true;
}

}  // namespace

MavSigningKey ReadMavSigningKey(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  RequireFile(path, "signing key file");
  constexpr fs::perms kOthers = fs::perms::group_all | fs::perms::others_all;
  if ((fs::status(path).permissions() & kOthers) != fs::perms::none) {
    throw Error("signing key file " + path.string() +
                " may be used by others than its owner; run: chmod 600 " + path.string());
  }
  const std::string content = ReadFile(path);
  MavSigningKey key;
  if (content.size() == key.size()) {
    std::ranges::transform(content, key.begin(),
                           [](char byte) { return static_cast<std::uint8_t>(byte); });
    return key;
  }
  if (ParseHexKey(content, &key)) return key;
  throw Error("signing key file " + path.string() +
              " needs 32 bytes or 64 hexadecimal digits, it has " + std::to_string(content.size()) +
              " bytes; make one with: openssl rand -hex 32");
}

std::uint64_t MavTimestamp(double unix_s) {
  const double units = std::floor((unix_s - kUnixSecondsOf2015) * kUnitsPerSecond);
  if (!(units > 0)) return 0;
  return std::min(static_cast<std::uint64_t>(std::min(units, 1e18)), kGreatestTimestamp);
}

MavSigningState ReadMavSigningState(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return {};
  MavSigningState state;
  try {
    const nlohmann::json json = nlohmann::json::parse(ReadFile(path));
    state.timestamp = json.at("timestamp").get<std::uint64_t>();
    for (const auto& stream : json.at("streams")) {
      const auto key = std::tuple(stream.at("system").get<std::uint8_t>(),
                                  stream.at("component").get<std::uint8_t>(),
                                  stream.at("link").get<std::uint8_t>());
      state.streams[key] = stream.at("timestamp").get<std::uint64_t>();
    }
  } catch (const nlohmann::json::exception& error) {
    throw Error("signing state " + path.string() + " is damaged: " + error.what() +
                "; delete it when nobody can have recorded this link");
  }
  return state;
}

void WriteMavSigningState(const std::filesystem::path& path, const MavSigningState& state) {
  nlohmann::json streams = nlohmann::json::array();
  for (const auto& [key, timestamp] : state.streams) {
    const auto& [system, component, link] = key;
    streams.push_back(
        {{"system", system}, {"component", component}, {"link", link}, {"timestamp", timestamp}});
  }
  const nlohmann::json json = {{"timestamp", state.timestamp}, {"streams", streams}};
  WriteFileAtomically(path, json.dump(1) + "\n");
}

MavSigning::MavSigning(const MavSigningKey& key, MavSigningOptions options, MavSigningState state,
                       std::function<void(const MavSigningState&)> save)
    : key_(key),
      options_(std::move(options)),
      state_(std::move(state)),
      last_timestamp_(state_.timestamp),
      save_(std::move(save)) {}

std::uint64_t MavSigning::NextTimestamp(double unix_s) {
  last_timestamp_ = std::max(last_timestamp_ + 1, MavTimestamp(unix_s));
  if (last_timestamp_ > kGreatestTimestamp) {
    throw Error("the timestamps of MAVLink signatures are used up; is the clock right?");
  }
  if (last_timestamp_ > state_.timestamp) {
    state_.timestamp =
        last_timestamp_ + static_cast<std::uint64_t>(options_.reserve_s * kUnitsPerSecond);
    if (save_) save_(state_);
  }
  return last_timestamp_;
}

void MavSigning::Sign(MavFrame* frame, double unix_s) {
  frame->incompat_flags |= kMavSignedFlag;
  frame->checksum = MavChecksumOf(*frame, FindMavMessage(frame->message_id)->crc_extra);
  frame->signature = MavSignature{options_.link_id, NextTimestamp(unix_s), {}};
  frame->signature->hash = HashOf(*frame, key_);
}

MavSignatureVerdict MavSigning::Judge(const MavFrame& frame, double unix_s) {
  if (!frame.signature) {
    return options_.unsigned_messages.contains(frame.message_id) ? MavSignatureVerdict::kAccepted
                                                                 : MavSignatureVerdict::kUnsigned;
  }
  const MavSignature& signature = *frame.signature;
  const auto hash = HashOf(frame, key_);
  if (CRYPTO_memcmp(hash.data(), signature.hash.data(), hash.size()) != 0) {
    return MavSignatureVerdict::kWrong;
  }
  const auto stream = std::tuple(frame.system_id, frame.component_id, signature.link_id);
  const auto known = state_.streams.find(stream);
  if (known != state_.streams.end() && signature.timestamp <= known->second) {
    return MavSignatureVerdict::kReplayed;
  }
  const auto tolerance = static_cast<std::uint64_t>(kOldestNewStreamS * kUnitsPerSecond);
  const std::uint64_t local = std::max(last_timestamp_, MavTimestamp(unix_s));
  if (known == state_.streams.end() && signature.timestamp + tolerance < local) {
    return MavSignatureVerdict::kTooOld;
  }
  state_.streams[stream] = signature.timestamp;
  // A peer whose clock is ahead would find our packets too old.
  last_timestamp_ = std::max(last_timestamp_, signature.timestamp);
  return MavSignatureVerdict::kAccepted;
}

MavSignatureVerdict MavSigning::Check(const MavFrame& frame, double unix_s) {
  const MavSignatureVerdict verdict = Judge(frame, unix_s);
  switch (verdict) {
    case MavSignatureVerdict::kAccepted:
      ++counts_.accepted;
      break;
    case MavSignatureVerdict::kUnsigned:
      ++counts_.without_signature;
      break;
    case MavSignatureVerdict::kWrong:
      ++counts_.wrong;
      break;
    case MavSignatureVerdict::kReplayed:
      ++counts_.replayed;
      break;
    case MavSignatureVerdict::kTooOld:
      ++counts_.too_old;
      break;
  }
  return verdict;
}

MavSetupSigning MakeSetupSigning(const MavSigningKey& key, double unix_s,
                                 std::uint8_t target_system, std::uint8_t target_component) {
  MavSetupSigning setup;
  setup.initial_timestamp = MavTimestamp(unix_s);
  setup.secret_key = key;
  setup.target_system = target_system;
  setup.target_component = target_component;
  return setup;
}

}  // namespace colmap_ext
