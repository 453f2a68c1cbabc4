// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {

// The built-in places that places() lists. Each call builds a new one.
Place laboratory();
Place cluttered();
Place glassOffice();
Place peopleRoom();
Place fourRooms();
Place corridorRing();
Place twins();
Place straightCorridor();
Place hall();
Place town();
Place largeTown();
Place sparseTown();

}  // namespace kestrel
