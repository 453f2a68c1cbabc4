#include "kestrel_slam/mapping/mapper.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/pose_uncertainty.h"

namespace kestrel_slam {
namespace {

/// A vehicle that seems to move farther than this between two scans was moved, or jumped in the
/// map: its motion says nothing of the next one.
constexpr double kMaxStepM = 1.0;
/// Largest factor of the search windows after a long lost state.
constexpr double kMaxSearchScale = 8.0;
/// A lost vehicle is found where the scan fits well (search_score), and where this share of it is
/// in known space: in a large window something fits half of a scan almost everywhere.
constexpr double kFoundKnownShare = 0.5;
/// A scan that seems to be farther from the prediction than this speed explains has to fit much
/// better there: a room that looks different from another height is no reason to jump.
constexpr double kMaxSpeed = 3.0;  // m/s
constexpr double kMinPlausibleM = 0.05;

/// No vehicle turns faster, and the heading is no more noisy than this.
constexpr double kMaxTurnRate = 12.0;  // rad/s
constexpr double kTurnNoise = 0.1;     // rad
/// Lost for longer than this in a row, the vehicle may have been turned by hand.
constexpr int kTrustedLostScans = 40;

/// Time constant of the velocity, s.
constexpr double kVelocityTime = 0.15;

/// No laser sees farther, and no vehicle flies farther from its start: beyond this, or not finite,
/// a number is broken and is not used.
constexpr float kMaxRayM = 1e4F;
constexpr double kMaxPositionM = 1e6;

bool isUsable(const PlanarRay& ray) {
  // Written so that NaN fails.
  return ray.origin.cwiseAbs().sum() < kMaxRayM && ray.end.cwiseAbs().sum() < kMaxRayM;
}

bool isUsable(const Pose2& pose) {
  return pose.isFinite() && std::abs(pose.x) < kMaxPositionM && std::abs(pose.y) < kMaxPositionM;
}

/// The scan without its broken rays.
PlanarScan repaired(const PlanarScan& scan) {
  PlanarScan result = scan;
  const auto broken = [](const PlanarRay& ray) { return !isUsable(ray); };
  result.rays.erase(std::remove_if(result.rays.begin(), result.rays.end(), broken),
                    result.rays.end());
  if (result.heading && !std::isfinite(*result.heading)) result.heading.reset();
  if (result.speed && !result.speed->allFinite()) result.speed.reset();
  return result;
}

Points hitsOf(const PlanarScan& scan) {
  Points points;
  points.reserve(scan.rays.size());
  for (const PlanarRay& ray : scan.rays) {
    if (ray.hit) points.push_back(ray.end);
  }
  return points;
}

Pose2 halfway(const Pose2& a, const Pose2& b) {
  return {0.5 * (a.x + b.x), 0.5 * (a.y + b.y), a.theta + 0.5 * normalizeAngle(b.theta - a.theta)};
}

/// Whether the motion knows more of the degenerate direction than the scan. Without any sensor of
/// the motion the little that a scan sees is better than nothing: one scan that is moved by 2 cm
/// enters the map there, and the loops of whole buildings no longer close.
bool isOpen(const MatchResult& match, Carrier carrier) {
  constexpr double kNothing = 0.005;  // of the beams
  return match.degenerate && (carrier != Carrier::kVelocity || match.constraint < kNothing);
}

/// The scan says nothing of the direction that it does not constrain: what the walls' cells say of
/// it is their own raster.
void holdDegenerate(const Pose2& carried, MatchResult& match) {
  const Eigen::Vector2d& along = match.degenerate_direction;
  const double moved = along.dot(carried.translation() - match.pose.translation());
  const Eigen::Vector2d place = match.pose.translation() + moved * along;
  match.pose = Pose2(place.x(), place.y(), match.pose.theta);
}

}  // namespace

const char* toString(MatchState state) {
  switch (state) {
    case MatchState::kOk:
      return "ok";
    case MatchState::kDegraded:
      return "degraded";
    case MatchState::kLost:
      return "lost";
  }
  return "unknown";
}

struct Mapper::State {
  explicit State(const MapperConfig& c)
      : config(c), map(c.grid, submapOptions(c.matcher)), matcher(makeMatcher(c.matcher)) {}

  MapperConfig config;
  Submap map;
  std::unique_ptr<Matcher> matcher;

  Pose2 pose;                            ///< map_T_base of the last scan
  Pose2 motion;                          ///< from the scan before the last one to the last one
  Pose2 inserted_pose;                   ///< of the last scan that entered the map
  std::optional<Pose2> odom;             ///< odom_T_base of the last scan
  std::optional<double> heading;         ///< of the gyro, at the last scan, rad
  std::optional<Eigen::Vector2d> speed;  ///< of the accelerometer, at the last scan
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< in map, smoothed, m/s
  double time = 0.0;                                   ///< of the last scan
  double found_time = 0.0;                             ///< of the last scan that was not lost
  int lost_scans = 0;                                  ///< in a row
  PoseUncertainty uncertainty;                         ///< of `pose`
  bool placed = false;  ///< somebody said where the vehicle is: search around there

  MatchRequest request(const Points& points, const PlanarScan& scan,
                       const std::optional<Pose2>& odom_now) const;
  std::optional<double> turnSince(const PlanarScan& scan) const;
  std::optional<Pose2> carried(const MatchRequest& request, const PlanarScan& scan,
                               const std::optional<Pose2>& odom_now) const;
  Carrier carrierOf(const PlanarScan& scan, const std::optional<Pose2>& odom_now) const;
  Eigen::Vector2d gainedSpeed(const PlanarScan& scan) const;
  MatchState judge(const MatchResult& match, bool was_lost) const;
  void move(const MatchResult& match, const Pose2& prediction, MatchState match_state,
            const PlanarScan& scan);
  void updateVelocity(const Pose2& next, const PlanarScan& scan, bool unknown);
  bool movedEnough() const;
};

/// The starts, best first (paper 002 eq. 5-6: the motion goes on as it was). Odometry comes second:
/// its bias would otherwise pull every scan of a corridor a little the same way.
MatchRequest Mapper::State::request(const Points& points, const PlanarScan& scan,
                                    const std::optional<Pose2>& odom_now) const {
  MatchRequest result{points, pose, {}, false, 1.0};
  const Pose2 continued = pose * motion;
  result.starts = {continued, pose, halfway(pose, continued)};
  const std::optional<double> turn = turnSince(scan);
  const bool has_turn = turn.has_value();
  if (has_turn) {
    // The gyro knows the rotation better than any motion model, and at the rate of such lasers the
    // smoothed velocity the motion better than two noisy poses. Without both in the last place.
    const double theta = pose.theta + *turn;
    const double seconds = std::clamp(scan.time - time, 0.0, config.gap_s);
    const Eigen::Vector2d moved =
        pose.translation() + seconds * (velocity + 0.5 * gainedSpeed(scan));
    const Pose2 predicted(moved.x(), moved.y(), theta), turned(pose.x, pose.y, theta);
    result.starts = {predicted, turned, halfway(turned, predicted), continued};
    result.trusted = speed && scan.speed && lost_scans == 0 && !placed;
  }
  if (odom && odom_now) {
    const auto place = lost_scans > 0 ? result.starts.begin() : result.starts.end();
    result.starts.insert(place, pose * (odom->inverse() * *odom_now));
  }
  result.turn_known = has_turn && lost_scans < kTrustedLostScans;
  result.lost = lost_scans > 0 || scan.time - time > config.gap_s;
  result.search_all_round = result.lost && !result.turn_known;
  if (result.lost) {
    const double flown = kMaxSpeed * (scan.time - found_time);
    result.search_scale =
        std::clamp(1.0 + flown / config.matcher.wide_window.linear_m, 1.0, kMaxSearchScale);
  }
  result.plausible_m = std::max(kMinPlausibleM, kMaxSpeed * (scan.time - found_time));
  if (placed) result.plausible_m = std::numeric_limits<double>::infinity();
  return result;
}

/// What the gyro says of the turn since the last scan, rad; nothing after a gap, or where the
/// heading began anew.
std::optional<double> Mapper::State::turnSince(const PlanarScan& scan) const {
  const double seconds = scan.time - time;
  if (!heading || !scan.heading || !(seconds <= config.gap_s)) return std::nullopt;
  const double turn = *scan.heading - *heading;
  return std::abs(turn) <= kMaxTurnRate * seconds + kTurnNoise ? std::optional(turn) : std::nullopt;
}

/// What the accelerometer says of the velocity since the last scan, in map, m/s.
Eigen::Vector2d Mapper::State::gainedSpeed(const PlanarScan& scan) const {
  if (!turnSince(scan) || !speed || !scan.speed) return Eigen::Vector2d::Zero();
  return Eigen::Rotation2Dd(pose.theta - *heading) * (*scan.speed - *speed);
}

Carrier Mapper::State::carrierOf(const PlanarScan& scan,
                                 const std::optional<Pose2>& odom_now) const {
  if (odom && odom_now) return Carrier::kOdometry;
  return turnSince(scan) && speed && scan.speed ? Carrier::kAccelerometer : Carrier::kVelocity;
}

/// Where the motion alone leads, for the directions that the scan does not constrain; nothing after
/// a gap, while lost, and where somebody placed the vehicle.
std::optional<Pose2> Mapper::State::carried(const MatchRequest& request, const PlanarScan& scan,
                                            const std::optional<Pose2>& odom_now) const {
  const double seconds = scan.time - time;
  if (lost_scans > 0 || placed || !(seconds >= 0.0) || seconds > config.gap_s) return std::nullopt;
  return odom && odom_now ? pose * (odom->inverse() * *odom_now) : request.starts.front();
}

MatchState Mapper::State::judge(const MatchResult& match, bool was_lost) const {
  if (match.score < (was_lost ? config.matcher.search_score : config.lost_score) ||
      match.known < (was_lost ? kFoundKnownShare : config.min_known_share)) {
    return MatchState::kLost;
  }
  const bool good = match.score >= config.matcher.search_score && !match.degenerate;
  return good ? MatchState::kOk : MatchState::kDegraded;
}

void Mapper::State::move(const MatchResult& match, const Pose2& prediction, MatchState match_state,
                         const PlanarScan& scan) {
  const bool lost = match_state == MatchState::kLost;
  const Pose2 next = !lost ? match.pose : isUsable(prediction) ? prediction : pose;
  motion = lost || placed ? Pose2() : pose.inverse() * next;
  if (motion.distance() > kMaxStepM) motion = Pose2();
  updateVelocity(next, scan, lost || placed);
  pose = next;
  lost_scans = lost ? lost_scans + 1 : 0;
  placed = false;
}

/// Smoothed: over one period of a 40 Hz laser the noise of the poses is as large as the motion. The
/// accelerometer, where there is one, tells the changes without delay; a lost vehicle flies on.
void Mapper::State::updateVelocity(const Pose2& next, const PlanarScan& scan, bool unknown) {
  const double seconds = scan.time - time;
  const Eigen::Vector2d gained = gainedSpeed(scan);
  if (placed || !(seconds > 0.0) || seconds > config.gap_s) {
    velocity.setZero();
    return;
  }
  if (unknown) {
    velocity = scan.speed ? Eigen::Vector2d(velocity + gained) : Eigen::Vector2d::Zero();
    return;
  }
  const Eigen::Vector2d measured = (next.translation() - pose.translation()) / seconds;
  const Eigen::Vector2d correction = measured - (velocity + 0.5 * gained);
  velocity += gained + seconds / (seconds + kVelocityTime) * correction;
}

bool Mapper::State::movedEnough() const {
  const Pose2 moved = inserted_pose.inverse() * pose;
  return moved.distance() >= config.insert_distance_m ||
         std::abs(moved.theta) >= config.insert_angle_rad;
}

Mapper::Mapper(const MapperConfig& config) : state_(std::make_unique<State>(config)) {}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;

MapperResult Mapper::process(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  const auto usable = [](const PlanarRay& ray) { return isUsable(ray); };
  if (!std::all_of(scan.rays.begin(), scan.rays.end(), usable)) {
    return process(repaired(scan), odom_T_base);
  }
  if (odom_T_base && !isUsable(*odom_T_base)) return process(scan);
  if (scan.heading && !std::isfinite(*scan.heading)) return process(repaired(scan), odom_T_base);
  if (scan.speed && !scan.speed->allFinite()) return process(repaired(scan), odom_T_base);
  State& s = *state_;
  MapperResult result;
  const Points points = hitsOf(scan);
  const bool first = s.map.scans() == 0;
  if (!first && !points.empty()) {
    const MatchRequest request = s.request(points, scan, odom_T_base);
    result.match = s.matcher->match(s.map, request);
    const Carrier carrier = s.carrierOf(scan, odom_T_base);
    const std::optional<Pose2> carried = s.carried(request, scan, odom_T_base);
    if (carried && isOpen(result.match, carrier)) holdDegenerate(*carried, result.match);
    result.evaluation = evaluationFunction(result.match, s.config.evaluation);
    result.state = s.judge(result.match, request.lost);
    const double moved = (s.pose.inverse() * result.match.pose).distance();
    s.move(result.match, request.starts.front(), result.state, scan);
    if (result.state == MatchState::kLost) {
      s.uncertainty.lose(s.pose);
    } else {
      const double seconds = std::min(std::max(0.0, scan.time - s.time), s.config.gap_s);
      s.uncertainty.update(s.map.surface(), points, result.match, seconds, moved, carrier);
    }
  } else if (first && !points.empty()) {
    result.match.pose = s.pose;
    result.match.covariance.setZero();  // the first scan defines the map
    result.match.score = result.match.known = 1.0;
    result.match.converged = true;
    result.state = MatchState::kOk;
    s.uncertainty.begin(s.pose);
  }
  const bool accepted =
      !s.config.evaluation.enabled || first || result.evaluation < s.config.evaluation.threshold;
  if (result.state != MatchState::kLost && accepted && (first || s.movedEnough())) {
    // Without an IMU the laser is level: what it has not seen before moves, or was moved.
    const bool new_view = scan.speed && result.match.score < s.config.matcher.good_score;
    result.map_full = !s.map.insert(scan, s.pose, new_view);
    result.inserted = true;
    s.uncertainty.insert();
    s.inserted_pose = s.pose;
  }
  s.odom = odom_T_base;
  s.heading = scan.heading;
  s.speed = scan.speed;
  s.time = scan.time;
  if (result.state != MatchState::kLost) s.found_time = scan.time;
  result.pose = s.pose;
  result.velocity = Eigen::Rotation2Dd(-s.pose.theta) * s.velocity;
  result.uncertain = s.uncertainty.last();
  result.covariance = result.uncertain.covariance();
  result.motion_covariance = s.uncertainty.motion();
  result.searched = result.match.searched;
  return result;
}

void Mapper::reset(const Pose2& map_T_base) {
  if (!isUsable(map_T_base)) return;
  const MapperConfig config = state_->config;
  state_ = std::make_unique<State>(config);
  state_->pose = map_T_base;
}

void Mapper::setPose(const Pose2& map_T_base) {
  if (!isUsable(map_T_base)) return;
  state_->pose = map_T_base;
  state_->motion = Pose2();
  state_->odom.reset();
  state_->heading.reset();
  state_->velocity.setZero();
  state_->placed = true;
}

const Pose2& Mapper::pose() const { return state_->pose; }
const MapperConfig& Mapper::config() const { return state_->config; }
MapSnapshot Mapper::snapshot() const { return state_->map.grid().snapshot(); }
std::size_t Mapper::memoryBytes() const { return state_->map.memoryBytes(); }

}  // namespace kestrel_slam
