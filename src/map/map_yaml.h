// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

namespace kestrel {

using YamlKeys = std::map<std::string, std::string>;

/// Parses the flat YAML of a map: one `key: value` per line, comments, and lists in brackets or as
/// `- item`. Throws std::runtime_error with the reason.
YamlKeys parseMapYaml(const std::string& text);

/// The name of an image as a YAML value: in double quotes where a parser needs them.
std::string yamlFileName(const std::string& name);

}  // namespace kestrel
