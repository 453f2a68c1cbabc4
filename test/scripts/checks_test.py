#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Each check of the repository (scripts/check_*) finds errors planted in a copy of it."""

import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
COPIED = ("cmake", "include", "src", "test/map", "test/filter", "test/scripts", "scripts",
          "CMakeLists.txt", ".clang-format")


class PlantedErrors(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.copy = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def copy_sources(self):
        for name in COPIED:
            source, target = ROOT / name, self.copy / name
            target.parent.mkdir(parents=True, exist_ok=True)
            if source.is_dir():
                shutil.copytree(source, target, dirs_exist_ok=True)
            elif source.exists():
                shutil.copy(source, target)

    def run_check(self, name):
        return subprocess.run([str(ROOT / "scripts" / name), str(self.copy)],
                              capture_output=True, text=True, check=False)

    def plant(self, file, text):
        path = self.copy / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def assert_finds(self, check, *messages):
        result = self.run_check(check)
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        for message in messages:
            self.assertIn(message, result.stdout)


class Setup(unittest.TestCase):
    def test_messages_of_the_nodes_can_be_shown(self):
        """rostopic echo needs the Python package of every message that the nodes publish."""
        packages = {"diagnostic_msgs", "std_msgs", "tf2_msgs"}
        for file in (ROOT / "src/ros").rglob("*.cpp"):
            packages |= set(re.findall(r"advertise<(\w+)::", file.read_text()))
        setup = (ROOT / "scripts/setup").read_text()
        for package in packages - {"kestrel_slam"}:
            self.assertRegex(setup, rf"\bpython3-{package.replace('_', '-')}\b")


class Includes(PlantedErrors):
    SPDX = "// SPDX-License-Identifier: BSD-3-Clause\n"

    def setUp(self):
        super().setUp()
        self.copy_sources()

    def plant_include(self, file, include):
        self.plant(file, f"{self.SPDX}#include {include}\n")

    def test_upwards(self):
        self.plant_include("src/map/planted.cpp", '"kestrel_slam/mapping/mapper.h"')
        self.assert_finds("check_includes", "src/map/planted.cpp:2: map may not include mapping")

    def test_beside(self):
        self.plant_include("include/kestrel_slam/filter/planted.h", '"kestrel_slam/map/submap.h"')
        self.assert_finds("check_includes",
                          "include/kestrel_slam/filter/planted.h:2: filter may not include map")

    def test_nodes_side_by_side(self):
        self.plant_include("src/ros/mapper/planted.cpp",
                           '"kestrel_slam/ros/filter/pose_filter_node.h"')
        self.assert_finds("check_includes", "ros/mapper may not include ros/filter")

    def test_private_header_of_another_folder(self):
        self.plant_include("test/map/planted_test.cpp", '"../../src/filter/measurement.h"')
        self.assert_finds("check_includes", "test/map/planted_test.cpp:2: src/filter/measurement.h "
                                            "is a private header of filter")

    def test_private_header_of_the_own_folder(self):
        self.plant_include("test/filter/planted_test.cpp", '"../../src/filter/measurement.h"')
        self.assertNotIn("planted_test", self.run_check("check_includes").stdout)

    def test_ros(self):
        self.plant_include("src/pipeline/planted.cpp", "<sensor_msgs/Imu.h>")
        self.plant_include("src/pipeline/planted_service.cpp", "<kestrel_slam/SaveMap.h>")
        self.plant_include("src/recording/planted.cpp", '"kestrel_slam/messages/conversions.h"')
        self.assert_finds("check_includes",
                          "planted.cpp:2: sensor_msgs/Imu.h is a header of ROS",
                          "planted_service.cpp:2: kestrel_slam/SaveMap.h is a header of ROS",
                          "planted.cpp:2: only recording/bag uses messages/")

    def test_missing_header(self):
        self.plant_include("src/map/planted.cpp", '"kestrel_slam/map/no_such_header.h"')
        self.assert_finds("check_includes", "map/no_such_header.h does not exist")

    def test_long_file_and_tools(self):
        self.plant("src/tools/planted.cpp", self.SPDX * 351)
        self.assert_finds("check_includes", "src/tools/planted.cpp:351: 351 lines",
                          "src/tools:1: this folder must not exist")

    def test_library_linked_upwards(self):
        libraries = self.copy / "cmake/libraries.cmake"
        libraries.write_text(libraries.read_text().replace(
            "kestrel_library(sensor LINKS kestrel_geometry",
            "kestrel_library(sensor LINKS kestrel_geometry kestrel_map"))
        self.assert_finds("check_includes", "sensor is linked to map, which is not above it")


class Names(PlantedErrors):
    def plant_type(self, file, before, after=""):
        self.plant(file, f"namespace kestrel {{\n{before}struct WallPoint {{\n}};\n{after}}}  "
                         "// namespace kestrel\n")

    def setUp(self):
        super().setUp()
        self.plant_type("include/kestrel_slam/map/wall.h", "struct Other;\n")

    def test_two_folders(self):
        self.plant_type("src/merging/planted.cpp", "")
        self.assert_finds("check_names", "src/merging/planted.cpp:2: kestrel::WallPoint is also "
                                         "defined in include/kestrel_slam/map/wall.h:3")

    def test_nothing_to_find(self):
        self.plant_type("src/merging/unnamed.cpp", "namespace {\n", "}  // namespace\n")
        self.plant_type("src/merging/inner.cpp", "namespace other {\n", "}  // namespace other\n")
        self.plant("src/merging/nested.cpp", "namespace kestrel {\nstruct Wall::WallPoint {\n};\n"
                                             "struct Other;\n}  // namespace kestrel\n")
        result = self.run_check("check_names")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


class Format(PlantedErrors):
    def setUp(self):
        super().setUp()
        shutil.copy(ROOT / ".clang-format", self.copy)
        self.plant("CMakeLists.txt", "# SPDX-License-Identifier: BSD-3-Clause\n")
        self.plant("src/map/good.cpp", f"{Includes.SPDX}int good() {{ return 1; }}\n")

    def test_nothing_to_find(self):
        self.assertEqual(self.run_check("check_format").returncode, 0)

    def test_indentation(self):
        self.plant("src/map/planted.cpp", f"{Includes.SPDX}int planted() {{\n     return 1;\n}}\n")
        self.assert_finds("check_format", "src/map/planted.cpp:2:")

    def test_spdx(self):
        self.plant("src/map/planted.cpp", "int planted() { return 1; }\n")
        self.plant("scripts/planted", "#!/usr/bin/env bash\n")
        self.assert_finds("check_format", "src/map/planted.cpp:1: the SPDX line is missing",
                          "scripts/planted:1: the SPDX line is missing")


GOOD_PAGE = """# A page

| a | b |
|---|---|
| 1 | `x\\|y` |

[itself](#a-page), [other](doc/other.md#a-heading), `scripts/run`, `src/<folder>/x.cpp`,
`src/map/*.cpp`, `doc/`, `other.md`, [web](https://example.org/nothing#here)

```
| not | a table |
scripts/run roslaunch kestrel_slam mapper.launch
```
"""


class Docs(PlantedErrors):
    def setUp(self):
        super().setUp()
        for file in ("scripts/run", "src/map/submap.cpp", "launch/mapper.launch"):
            self.plant(file, "")
        self.plant("doc/other.md", "# A heading\n")
        self.plant("README.md", GOOD_PAGE)

    def plant_line(self, text):
        self.plant("README.md", GOOD_PAGE + "\n" + text + "\n")

    def test_nothing_to_find(self):
        result = self.run_check("check_docs")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_rows_without_a_table(self):
        self.plant_line("| a | b |\n|---|\n| 1 | 2 |")
        self.assert_finds("check_docs", "README.md:15: this row of pipes is not shown as a table",
                          "README.md:17: this row of pipes is not shown as a table")

    def test_rows_inside_html(self):
        self.plant_line("<details>\n| a | b |\n|---|---|\n| 1 | 2 |\n</details>")
        self.assert_finds("check_docs", "README.md:16: this row of pipes is not shown as a table")

    def test_row_with_too_many_cells(self):
        self.plant_line("| a | b |\n|---|---|\n| 1 | `x|y` |")
        self.assert_finds("check_docs", "README.md:17: 3 cells in a table of 2")

    def test_links(self):
        self.plant_line('[a](doc/none.md) [b](doc/other.md#none) [c](#none) <img src="none.png">')
        self.assert_finds("check_docs", "README.md:15: the link doc/none.md leads nowhere",
                          "other.md has no heading #none", "README.md has no heading #none",
                          "the link none.png leads nowhere")

    def test_names_in_backticks(self):
        self.plant_line("`scripts/none --option` `config/none.yaml` `src/none/<name>.cpp` "
                        "`src/map/none*.h` `none.md` `roslaunch kestrel_slam none.launch`")
        self.assert_finds("check_docs", "README.md:15: there is no scripts/none",
                          "there is no config/none.yaml", "there is no src/none",
                          "there is no src/map/none*.h", "there is no file none.md",
                          "there is no launch/none.launch")


if __name__ == "__main__":
    unittest.main()
