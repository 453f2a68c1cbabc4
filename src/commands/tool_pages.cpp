// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/commands/tool_pages.h"

#include <algorithm>
#include <sstream>

#include "kestrel_slam/session/version.h"

namespace kestrel {
namespace {

/// Text for roff: a dash is a minus sign, and a line must not begin with a dot.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '-' || c == '\\') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return "\\&" + result;
}

bool isPositional(const CLI::Option& option) { return !option.nonpositional(); }

std::string namesOf(const CLI::Option& option) {
  if (isPositional(option)) return option.get_name();
  std::string names;
  for (const std::string& name : option.get_snames()) names += ", -" + name;
  for (const std::string& name : option.get_lnames()) names += ", --" + name;
  return names.substr(2);
}

/// The words in "TEXT:{none,use}" as "none use"; "" if there is no choice.
std::string choicesOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return "";
  std::string words = type.substr(open + 1, close - open - 1);
  std::replace(words.begin(), words.end(), ',', ' ');
  return words;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

}  // namespace

std::string manPage(const std::string& name, const CLI::App& app) {
  const std::string purpose = app.get_description();
  std::ostringstream page;
  page << ".TH " << upper(name) << " 1 \"\" \"kestrel_slam " << kVersion << "\"\n.SH NAME\n"
       << name << " \\- " << roff(purpose.substr(0, purpose.find('\n'))) << "\n.SH SYNOPSIS\n.B "
       << name << "\n[options]";
  for (const CLI::Option* option : app.get_options()) {
    if (isPositional(*option)) page << " " << roff(option->get_name());
  }
  page << "\n.SH DESCRIPTION\n" << roff(purpose) << "\n.SH OPTIONS\n";
  for (const CLI::Option* option : app.get_options()) {
    page << ".TP\n.B " << roff(namesOf(*option)) << "\n" << roff(option->get_description()) << "\n";
  }
  page << ".SH EXIT STATUS\n0: success; 1: bad input; 2: wrong usage.\n";
  return page.str();
}

std::string bashCompletion(const std::string& name, const CLI::App& app) {
  std::ostringstream values;
  std::string options;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& long_name : option->get_lnames()) {
      options += (options.empty() ? "" : " ") + ("--" + long_name);
      if (const std::string words = choicesOf(*option); !words.empty()) {
        values << "    --" << long_name << ") words=\"" << words << "\" ;;\n";
      }
      if (long_name != "set") continue;
      values << "    --set) words=$(\"$1\" --list-parameters 2>/dev/null |\n"
             << "      sed -n 's/^\\([a-z0-9_]*\\): .*/\\1=/p') ;;\n";
    }
  }
  const std::string function = "_kestrel_slam_" + name;
  return "# Completion of " + name + " for bash: source this file.\n" + function +
         "() {\n  local current=${COMP_WORDS[COMP_CWORD]} words=\"\"\n  case "
         "${COMP_WORDS[COMP_CWORD "
         "- 1]} in\n" +
         values.str() + "    *) [[ $current == -* ]] && words=\"" + options +
         "\" ;;\n  esac\n  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n  [[ "
         "${COMPREPLY[0]} == *= ]] && compopt -o nospace\n}\ncomplete -o default -F " +
         function + " " + name + "\n";
}

}  // namespace kestrel
