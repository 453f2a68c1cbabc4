# SPDX-License-Identifier: BSD-3-Clause
"""The parts of map_batch (../map_batch)."""


class BatchError(Exception):
    """An error that the user can mend; its text is one line."""
