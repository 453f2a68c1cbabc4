// SPDX-License-Identifier: BSD-3-Clause
#include "map_yaml.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

namespace kestrel {
namespace {

constexpr unsigned char kFirstPrintable = 0x20, kDelete = 0x7f, kFirstNotAscii = 0x80;
constexpr int kHexDigits = 2, kHexBase = 16;

std::string trimmed(const std::string& text) {
  const char* const blank = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

/// The character of the escape sequence whose backslash is at `at`, which is moved to its end.
char unescaped(const std::string& text, std::size_t& at) {
  if (++at >= text.size()) throw std::runtime_error("a text ends with a backslash");
  switch (text[at]) {
    case 'n':
      return '\n';
    case 't':
      return '\t';
    case 'x': {
      const std::string digits = text.substr(at + 1, kHexDigits);
      at += digits.size();
      return static_cast<char>(std::strtol(digits.c_str(), nullptr, kHexBase));
    }
    default:
      return text[at];
  }
}

/// The text between quotes. In double quotes a backslash escapes; in single quotes '' means '.
std::string unquoted(const std::string& text) {
  const char quote = text[0];
  std::string result;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"') {
      result += unescaped(text, i);
    } else if (text[i] != quote) {
      result += text[i];
    } else if (quote == '\'' && text.compare(i + 1, 1, "'") == 0) {
      result += text[i++];
    } else {
      return result;
    }
  }
  throw std::runtime_error("the value " + text + " has no closing quote");
}

/// The value without a trailing comment and without quotes.
std::string plainValue(const std::string& text) {
  const std::string value = trimmed(text);
  if (!value.empty() && (value[0] == '"' || value[0] == '\'')) return unquoted(value);
  if (!value.empty() && value[0] == '#') return {};
  return trimmed(value.substr(0, value.find(" #")));
}

bool isPlain(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= kFirstNotAscii || std::isalnum(byte) != 0 || c == '_' || c == '.' || c == '/' ||
         c == '-' || c == '+';
}

/// Quotes are always right. Plain texts are what people expect to see.
bool isPlainText(const std::string& text) {
  return !text.empty() && text[0] != '-' && std::all_of(text.begin(), text.end(), isPlain);
}

}  // namespace

YamlKeys parseMapYaml(const std::string& text) {
  YamlKeys keys;
  std::string key;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string content = trimmed(line);
    if (content.empty() || content[0] == '#' || content == "---") continue;
    if (content.rfind("- ", 0) == 0 && !key.empty()) {
      keys[key] += plainValue(content.substr(2)) + ",";
      continue;
    }
    const std::size_t colon = content.find(':');
    if (colon == std::string::npos) {
      throw std::runtime_error("the line '" + content + "' is not 'key: value'");
    }
    key = trimmed(content.substr(0, colon));
    keys[key] = plainValue(content.substr(colon + 1));
  }
  return keys;
}

std::string yamlFileName(const std::string& text) {
  if (isPlainText(text)) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < kFirstPrintable || byte == kDelete) {
      constexpr std::size_t kLength = 5;
      char hex[kLength];
      std::snprintf(hex, sizeof hex, "\\x%02x", static_cast<unsigned int>(byte));
      quoted += hex;
    } else {
      quoted += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
    }
  }
  return quoted + "\"";
}

}  // namespace kestrel
