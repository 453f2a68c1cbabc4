# SPDX-License-Identifier: BSD-3-Clause
"""Man page and completion for bash of map_batch, made from its options."""

import argparse
import re


def roff(text):
    return "\\&" + " ".join(text.split()).replace("\\", "\\\\").replace("-", "\\-")


def options_of(parser):
    """The options and arguments, with their help as --help shows it."""
    return [action for action in parser._actions  # pylint: disable=protected-access
            if action.help is not argparse.SUPPRESS]


def man_page(parser):
    lines = [f".TH {parser.prog.upper()} 1 \"\" \"kestrel_slam\"", ".SH NAME",
             f"{parser.prog} \\- {roff(re.split(r'[.]( |$)', parser.description)[0])}", ".SH SYNOPSIS",
             f".B {parser.prog}", "[options] FOLDER|LIST|RECORDING... \\-\\-output DIR",
             ".SH DESCRIPTION", roff(parser.description), ".SH OPTIONS"]
    for action in options_of(parser):
        name = ", ".join(action.option_strings) or action.metavar
        value = action.metavar if action.option_strings and action.metavar else ""
        lines += [".TP", f".B {roff(f'{name} {value}')}", roff((action.help or "") % vars(action))]
    return "\n".join([*lines, ".SH EXIT STATUS", roff(parser.epilog)]) + "\n"


def bash_completion(parser):
    names = " ".join(name for action in options_of(parser) for name in action.option_strings
                     if name.startswith("--"))
    function = f"_kestrel_slam_{parser.prog}"
    values = "".join(f"    {action.option_strings[-1]}) words=\"{action.metavar.replace('|', ' ')}\" ;;\n"
                     for action in options_of(parser)
                     if action.option_strings and action.metavar and "|" in action.metavar)
    return (f"# Completion of {parser.prog} for bash: source this file.\n{function}() {{\n"
            "  local current=${COMP_WORDS[COMP_CWORD]} words=\"\"\n"
            "  case ${COMP_WORDS[COMP_CWORD - 1]} in\n" + values +
            "    --set) words=$(\"$1\" --list-parameters 2>/dev/null |\n"
            "      sed -n 's/^\\([a-z0-9_]*\\): .*/\\1=/p') ;;\n"
            f"    *) [[ $current == -* ]] && words=\"{names}\" ;;\n  esac\n"
            "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
            "  [[ ${COMPREPLY[0]} == *= ]] && compopt -o nospace\n"
            f"}}\ncomplete -o default -F {function} {parser.prog}\n")


PAGES = {"--man-page": man_page, "--bash-completion": bash_completion}
