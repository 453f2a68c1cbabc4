// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace kestrel {

/// Where a map goes that a user wants at `path`: the absolute path without file extension, as
/// writeMap expects it. `~` is the home folder; an ending `.pgm`, `.yaml` or `.yml` is left out; in
/// a folder (an existing one, or a path that ends in `/`) the map is called `map`. Throws
/// std::runtime_error if the path is empty or cannot be written into a YAML file.
std::string mapStemOf(const std::string& path);

/// Creates the folder of a map where it is missing. Throws std::runtime_error with the reason.
void createFolderOf(const std::string& stem);

}  // namespace kestrel
