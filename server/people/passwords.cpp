#include "server/people/passwords.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace hoist::server {
namespace {

// Our own short list: keyboard walks, sequences and product words that people take when a password must have twelve characters. Compared without
// case, digits at the end and signs in between.
constexpr std::array<std::string_view, 40> kCommon{"password",
                                                   "passwort",
                                                   "passwordpassword",
                                                   "passwortpasswort",
                                                   "qwertyuiop",
                                                   "qwertzuiop",
                                                   "qwertyuiopas",
                                                   "asdfghjkl",
                                                   "yxcvbnm",
                                                   "zxcvbnm",
                                                   "abcdefghijkl",
                                                   "abcdefghijklm",
                                                   "letmein",
                                                   "letmeinplease",
                                                   "iloveyou",
                                                   "iloveyouiloveyou",
                                                   "welcome",
                                                   "willkommen",
                                                   "administrator",
                                                   "admin",
                                                   "adminadmin",
                                                   "engineer",
                                                   "therapist",
                                                   "therapeut",
                                                   "physiotherapy",
                                                   "physiotherapie",
                                                   "hospital",
                                                   "krankenhaus",
                                                   "clinic",
                                                   "klinik",
                                                   "hoist",
                                                   "hoisthoist",
                                                   "patient",
                                                   "patientpatient",
                                                   "changeme",
                                                   "changemeplease",
                                                   "rehabilitation",
                                                   "rehabilitationszentrum",
                                                   "defaultpassword",
                                                   "geheimgeheim"};

std::string letters_of(std::string_view text) {
  std::string out;
  for (const char c : text)
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) out.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  return out;
}
bool one_character(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [&](char c) { return c == text.front(); });
}
bool is_run(std::string_view text) {
  for (const int step : {1, -1}) {
    bool run = true;
    for (std::size_t i = 1; i < text.size() && run; ++i) run = text[i] == text[i - 1] + step || (text[i - 1] == '9' && text[i] == '0');
    if (run) return true;
  }
  return false;
}

}  // namespace

std::string password_fault(std::string_view password, std::string_view user) {
  if (password.size() < kPasswordLeast || password.size() > kPasswordMost) return "must have 12 to 128 characters";
  const std::string letters = letters_of(password);
  const bool common = std::find(kCommon.begin(), kCommon.end(), letters) != kCommon.end();
  if (common || one_character(password) || is_run(password) || (letters.empty() && is_run(password.substr(0, 8))))
    return "is one of the passwords that are tried first: take several words that do not belong together";
  if (!user.empty() && letters == letters_of(user)) return "must not be the user's name";
  return {};
}

std::string pin_fault(std::string_view pin) {
  if (pin.size() < kPinLeast || pin.size() > kPinMost || !std::all_of(pin.begin(), pin.end(), [](char c) { return c >= '0' && c <= '9'; }))
    return "must have 4 to 8 digits";
  if (one_character(pin) || is_run(pin)) return "must not be one digit repeated or a row of digits";
  return {};
}

std::string hash_secret(std::string_view secret, const HashLimits& limits) {
  std::array<char, crypto_pwhash_STRBYTES> text{};
  if (crypto_pwhash_str_alg(text.data(), secret.data(), secret.size(), limits.passes, limits.memory_bytes, crypto_pwhash_ALG_ARGON2ID13) !=
      0)
    return {};
  return text.data();
}

bool secret_matches(std::string_view secret, const std::string& hash) {
  return hash.size() < crypto_pwhash_STRBYTES && crypto_pwhash_str_verify(hash.c_str(), secret.data(), secret.size()) == 0;
}

}  // namespace hoist::server
