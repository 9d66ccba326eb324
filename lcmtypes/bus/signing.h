#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace muster {

/// The secret half of an Ed25519 key. Keys and signatures are written in hexadecimal digits: a
/// secret or public key in 64, a signature in 128.
///
/// Source: RFC 8032; libsodium's crypto_sign_detached.
class SigningKey {
 public:
  static SigningKey Fresh();
  /// Of the 64 digits of a secret key. Throws InputError, naming `from`; it never shows the text.
  static SigningKey Parse(std::string_view digits, const std::string& from);

  std::string Secret() const;
  std::string Public() const;
  std::string Sign(std::string_view text) const;

 private:
  SigningKey() = default;
  std::array<std::uint8_t, 64> secret_{};  ///< the seed, then the public key
};

/// Whether the owner of that public key has signed that text. False also where the key or the
/// signature is none.
bool IsSignature(std::string_view signature, std::string_view text, std::string_view public_key);

}  // namespace muster
