#include "lcmtypes/bus/signing.h"

#include <sodium.h>

#include <algorithm>

#include "base/check.h"

namespace muster {
namespace {

constexpr std::size_t kSeedBytes = crypto_sign_SEEDBYTES;

void StartSodiumForSigning() { MUSTER_CHECK(sodium_init() >= 0, "libsodium"); }

template <std::size_t n>
bool FromHex(std::string_view digits, std::array<std::uint8_t, n>* bytes) {
  std::size_t length = 0;
  return digits.size() == 2 * n &&
         sodium_hex2bin(bytes->data(), n, digits.data(), digits.size(), nullptr, &length,
                        nullptr) == 0 &&
         length == n;
}

std::string ToHex(const std::uint8_t* bytes, std::size_t n) {
  std::string digits(2 * n + 1, '\0');
  sodium_bin2hex(digits.data(), digits.size(), bytes, n);
  digits.pop_back();
  return digits;
}

const std::uint8_t* BytesOf(std::string_view text) {
  return reinterpret_cast<const std::uint8_t*>(text.data());
}

}  // namespace

SigningKey SigningKey::Fresh() {
  StartSodiumForSigning();
  SigningKey key;
  std::array<std::uint8_t, crypto_sign_PUBLICKEYBYTES> unused{};
  crypto_sign_keypair(unused.data(), key.secret_.data());
  return key;
}

SigningKey SigningKey::Parse(std::string_view digits, const std::string& from) {
  StartSodiumForSigning();
  std::array<std::uint8_t, kSeedBytes> seed{};
  if (!FromHex(digits, &seed)) {
    throw InputError(from, "key", "another text", "64 hexadecimal digits");
  }
  SigningKey key;
  std::array<std::uint8_t, crypto_sign_PUBLICKEYBYTES> unused{};
  crypto_sign_seed_keypair(unused.data(), key.secret_.data(), seed.data());
  return key;
}

std::string SigningKey::Secret() const { return ToHex(secret_.data(), kSeedBytes); }
std::string SigningKey::Public() const { return ToHex(secret_.data() + kSeedBytes, kSeedBytes); }

std::string SigningKey::Sign(std::string_view text) const {
  std::array<std::uint8_t, crypto_sign_BYTES> signature{};
  crypto_sign_detached(signature.data(), nullptr, BytesOf(text), text.size(), secret_.data());
  return ToHex(signature.data(), signature.size());
}

bool IsSignature(std::string_view signature, std::string_view text, std::string_view public_key) {
  StartSodiumForSigning();
  std::array<std::uint8_t, crypto_sign_BYTES> bytes{};
  std::array<std::uint8_t, crypto_sign_PUBLICKEYBYTES> key{};
  return FromHex(signature, &bytes) && FromHex(public_key, &key) &&
         crypto_sign_verify_detached(bytes.data(), BytesOf(text), text.size(), key.data()) == 0;
}

}  // namespace muster
