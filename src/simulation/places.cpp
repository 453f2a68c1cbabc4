// SPDX-License-Identifier: BSD-3-Clause
#include "built_in_places.h"
#include "find_by_name.h"
#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {

const std::vector<Place>& places() {
  static const std::vector<Place> all = {laboratory(), corridorRing(), straightCorridor(),
                                         hall(),       cluttered(),    glassOffice(),
                                         peopleRoom(), fourRooms(),    town(),
                                         largeTown(),  sparseTown(),   twins()};
  return all;
}

const Place& place(const std::string& name) { return findByName(places(), "world", name); }

}  // namespace kestrel
