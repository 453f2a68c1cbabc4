// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "kestrel_slam/session/session.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {

/// A vehicle that was carried away with a covered laser.
struct KidnapTrial {
  bool noticed = false;    ///< while it was covered, or within a second of seeing again
  bool found = false;      ///< at the right place
  bool wrong = false;      ///< it was told to be somewhere else
  double noticed_s = 0.0;  ///< after it saw again
  double travel_m = 0.0;   ///< until it was found

  /// Adds a scan `seconds` after the laser sees again. `error_m`: of its pose. Returns whether the
  /// vehicle is found.
  bool add(double seconds, bool lost, double error_m);
};

/// The sum of many.
struct KidnapSummary {
  std::size_t trials = 0, noticed = 0, found = 0, wrong = 0;

  void add(const KidnapTrial& trial);
  std::string text() const;
};

/// The vehicle is carried so far, and must be found within `kKidnapTravelM`, m.
constexpr double kLeastKidnapM = 5.0, kMostKidnapM = 40.0, kKidnapTravelM = 3.0;

/// A pose is wrong if it is farther than this from the truth, m.
constexpr double kWrongPoseM = 0.5;

/// Simulated flights in the finished map of a place. The vehicle is carried away with a covered
/// laser, on a straight way through the walls, and put down with any heading. Its IMU goes on.
class KidnappedFlights {
 public:
  /// Maps the flight of `place`. Throws the exceptions of runOffline().
  explicit KidnappedFlights(Place place);

  /// The flight with this number. Nothing if the distance of its two places is not that of a
  /// kidnapping.
  std::optional<KidnapTrial> fly(std::uint64_t number) const;

 private:
  struct Carriage;
  std::optional<Carriage> carriage(std::uint64_t number) const;

  Place place_;
  VehicleModel vehicle_;
  std::shared_ptr<const Session> session_;
  Pose2 map_T_world_;
};

}  // namespace kestrel
