// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <utility>

#include "inertia_check.h"
#include "kestrel_slam/mapping/jump_check.h"
#include "kestrel_slam/mapping/laser_odometry.h"
#include "kestrel_slam/mapping/local_map.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/mapping/motion_check.h"
#include "kestrel_slam/mapping/motion_model.h"
#include "kestrel_slam/mapping/odometry_slip.h"
#include "kestrel_slam/mapping/pose_uncertainty.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// What the mapper knows, and the steps of its work on a scan.
struct Mapper::State {
  explicit State(const MapperConfig& c, const Pose2& map_T_base = Pose2())
      : config(c),
        map(c.matchedGrid(), submapOptions(c.matcher), c.usedWindow()),
        matcher(makeMatcher(c.matcher)),
        motion(c, map_T_base),
        laser_odometry(c) {}

  State(const MapperConfig& c, Submap fixed)
      : config(c),
        map(std::move(fixed)),
        matcher(makeMatcher(c.matcher)),
        motion(c, Pose2()),
        laser_odometry(c) {
    uncertainty.begin(Pose2());
    uncertainty.insert();
  }

  MapperConfig config;
  LocalMap map;
  std::unique_ptr<Matcher> matcher;
  MotionModel motion;
  LaserOdometry laser_odometry;
  JumpCheck jumps;
  MotionCheck motion_check;
  InertiaCheck inertia;
  bool few_hits = false;             ///< the scan has hits in a small part of its beams
  UncertainPose inserted_pose;       ///< pose of the last inserted scan
  std::deque<Pose2> inserted_poses;  ///< of the last inserted scans
  PoseUncertainty uncertainty;
  int unsettled_scans = 0;  ///< scans that have to fit before the state is ok again
  /// Error of the position since an impossible motion, until the state is ok again. In this time
  /// the scans may be matched with something that moves, like the floor that a tilted laser sees.
  std::optional<PredictionError> doubt;

  void begin(MapperResult& result);
  void follow(const Points& points, const PlanarScan& scan, const std::optional<Pose2>& map_T_base,
              MapperResult& result);
  void match(const Points& points, const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
             const PredictionError& error, MapperResult& result);
  void compareAlong(const Points& points, const PlanarScan& scan, const Pose2& motion_prediction,
                    PredictionSource source, const PredictionError& predicted, MatchResult& match);
  void followAlong(const Points& points, double seconds, const Pose2& motion_prediction,
                   PredictionSource source, const AlongError& error, MatchResult& match);
  void compareWithInertia(const PlanarScan& scan, MatchResult& match);
  void updateInertia(const PlanarScan& scan, const MapperResult& result);
  void carry(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
             const PredictionError& error, MapperResult& result);
  void lookForSecond(const MatchRequest& request, PredictionSource source,
                     const PredictionError& error, MapperResult& result) const;
  SlipKind slipKindOf(const MapperResult& result) const;
  void matchElsewhere(const MatchRequest& request, MapperResult& result);
  bool isCarried(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                 const PredictionError& error) const;
  void carryUnmatched(const Points& points, const PlanarScan& scan,
                      const std::optional<Pose2>& odom_T_base, const PredictionError& error,
                      MapperResult& result);
  void fillFit(const Points& points, MapperResult& result) const;
  bool isBlank(const Points& points, const PlanarScan& scan,
               const std::optional<Pose2>& odom_T_base) const;
  bool isLikely(const MatchResult& match, const MatchRequest& request,
                const PredictionError& error);
  MatchState judge(const MatchResult& match, const MatchRequest& request,
                   const PredictionError& error);
  void growDoubt(const PlanarScan& scan);
  MatchResult matchInDoubt(const MatchRequest& request) const;
  bool contradictsMap(const MatchResult& match) const;
  void settle(bool out_of_reach, MapperResult& result);
  void insert(const PlanarScan& scan, bool has_odometry, MapperResult& result);
  bool movedEnough() const;
  bool isRepeated(const MapperResult& result) const;
};

}  // namespace kestrel
