// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/offline/offline_run.h"

namespace kestrel {

/// The session after a run. `before`: the session that the run continued, or null. Keyframes that
/// show nothing new are left out (withoutRepeated).
Session savedSession(const SubmapGraph& graph, const SlamConfig& config, const Session* before,
                     const OfflineRun& run);

}  // namespace kestrel
