// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/claims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/evaluation/consistency.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

constexpr std::size_t kPoseFields = 4, kCovarianceFields = 6;
constexpr std::size_t kFields = kPoseFields + 2 * kCovarianceFields;
constexpr int kStampDecimals = 6, kDigits = 9;

void write(std::ostream& out, const Eigen::Matrix3d& c) {
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) out << ' ' << c(row, column);
  }
}

Eigen::Matrix3d covarianceFrom(const double* v) {
  Eigen::Matrix3d c;
  c << v[0], v[1], v[2], v[1], v[3], v[4], v[2], v[4], v[5];
  return c;
}

const Claim* claimAt(const std::vector<Claim>& sorted, double stamp) {
  const auto after =
      std::lower_bound(sorted.begin(), sorted.end(), stamp - kStampTolerance,
                       [](const Claim& claim, double time) { return claim.stamp < time; });
  return after != sorted.end() && after->stamp <= stamp + kStampTolerance ? &*after : nullptr;
}

}  // namespace

void writeClaims(const std::string& path, const std::vector<Claim>& claims) {
  std::ostringstream out;
  out << "# stamp x y yaw, then map and match covariance: xx xy xt yy yt tt (m, rad)\n";
  for (const Claim& claim : claims) {
    const Pose2& pose = claim.pose.pose;
    out << std::fixed << std::setprecision(kStampDecimals) << claim.stamp << std::defaultfloat
        << std::setprecision(kDigits) << ' ' << pose.x << ' ' << pose.y << ' ' << pose.yaw;
    write(out, claim.pose.map_covariance);
    write(out, claim.pose.match_covariance);
    out << '\n';
  }
  writeFileAtomically(path, out.str());
}

std::vector<Claim> readClaims(const std::string& path) {
  const std::unique_ptr<std::istream> stream = openText(path);
  std::vector<Claim> claims;
  std::size_t number = 0;
  for (std::string line; std::getline(*stream, line);) {
    ++number;
    if (line.empty() || line.front() == '#') continue;
    std::istringstream fields(line);
    std::array<double, kFields> v{};
    std::size_t count = 0;
    for (std::string field; fields >> field; ++count) {
      if (count < kFields && parseFinite(field, v[count])) continue;
      count = kFields + 1;
      break;
    }
    if (count != kFields) {
      throw std::runtime_error(path + ", line " + std::to_string(number) + ": expected " +
                               std::to_string(kFields) +
                               " numbers; give the covariances.txt of map_recording");
    }
    claims.push_back({v[0],
                      {Pose2(v[1], v[2], v[3]), covarianceFrom(&v[kPoseFields]),
                       covarianceFrom(&v[kPoseFields + kCovarianceFields])}});
  }
  return claims;
}

ClaimEvaluation evaluateClaims(const std::vector<Claim>& claims,
                               const std::vector<Relation>& relations) {
  std::vector<Claim> sorted = claims;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Claim& a, const Claim& b) { return a.stamp < b.stamp; });
  std::vector<double> translations, rotations, nees;
  for (const Relation& relation : relations) {
    const Claim* a = claimAt(sorted, relation.stamp1);
    const Claim* b = claimAt(sorted, relation.stamp2);
    if (a == nullptr || b == nullptr) continue;
    const Pose2 found = a->pose.pose.inverse() * b->pose.pose;
    const Eigen::Vector3d error(found.x - relation.pose.x, found.y - relation.pose.y,
                                normalizeAngle(found.yaw - relation.pose.yaw));
    const Eigen::Matrix3d covariance = relativeCovariance(a->pose, b->pose);
    const double spread = covariance.topLeftCorner<2, 2>().trace();
    if (!(spread > 0.0) || !(covariance(2, 2) > 0.0)) continue;
    translations.push_back(error.head<2>().norm() / std::sqrt(spread));
    rotations.push_back(std::abs(error.z()) / std::sqrt(covariance(2, 2)));
    nees.push_back(neesOf(error, covariance));
  }
  return {statisticsOf(translations), statisticsOf(rotations), statisticsOf(nees)};
}

}  // namespace kestrel
