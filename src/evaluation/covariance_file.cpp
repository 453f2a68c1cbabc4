// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/covariance_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/evaluation/consistency.h"
#include "kestrel_slam/geometry/pose2.h"
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

const ScanCovariance* covarianceAt(const std::vector<ScanCovariance>& sorted, double stamp) {
  const auto after =
      std::lower_bound(sorted.begin(), sorted.end(), stamp - kStampTolerance,
                       [](const ScanCovariance& entry, double time) { return entry.stamp < time; });
  return after != sorted.end() && after->stamp <= stamp + kStampTolerance ? &*after : nullptr;
}

}  // namespace

std::string covariancesText(const std::vector<ScanCovariance>& covariances) {
  std::ostringstream out;
  out << "# stamp x y yaw, then map and match covariance: xx xy xt yy yt tt (m, rad)\n";
  for (const ScanCovariance& entry : covariances) {
    const Pose2& pose = entry.pose.pose;
    out << std::fixed << std::setprecision(kStampDecimals) << entry.stamp << std::defaultfloat
        << std::setprecision(kDigits) << ' ' << pose.x << ' ' << pose.y << ' ' << pose.yaw;
    write(out, entry.pose.map_covariance);
    write(out, entry.pose.match_covariance);
    out << '\n';
  }
  return out.str();
}

void writeCovariances(const std::string& path, const std::vector<ScanCovariance>& covariances) {
  writeFileAtomically(path, covariancesText(covariances));
}

std::vector<ScanCovariance> readCovariances(const std::string& path) {
  const std::unique_ptr<std::istream> stream = openText(path);
  std::vector<ScanCovariance> covariances;
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
                               " numbers; use the covariances.txt of map_recording");
    }
    covariances.push_back({v[0],
                           {Pose2(v[1], v[2], v[3]), covarianceFrom(&v[kPoseFields]),
                            covarianceFrom(&v[kPoseFields + kCovarianceFields])}});
  }
  return covariances;
}

CovarianceEvaluation evaluateCovariances(const std::vector<ScanCovariance>& covariances,
                                         const std::vector<Relation>& relations) {
  std::vector<ScanCovariance> sorted = covariances;
  std::stable_sort(
      sorted.begin(), sorted.end(),
      [](const ScanCovariance& a, const ScanCovariance& b) { return a.stamp < b.stamp; });
  std::vector<double> translations, rotations, nees;
  for (const Relation& relation : relations) {
    const ScanCovariance* a = covarianceAt(sorted, relation.stamp1);
    const ScanCovariance* b = covarianceAt(sorted, relation.stamp2);
    if (a == nullptr || b == nullptr) continue;
    const Eigen::Vector3d error = offsetBetween(relation.pose, a->pose.pose.between(b->pose.pose));
    const Eigen::Matrix3d covariance = relativeCovariance(a->pose, b->pose);
    const double variance = covariance.topLeftCorner<2, 2>().trace();
    if (!(variance > 0.0) || !(covariance(2, 2) > 0.0)) continue;
    translations.push_back(error.head<2>().norm() / std::sqrt(variance));
    rotations.push_back(std::abs(error.z()) / std::sqrt(covariance(2, 2)));
    nees.push_back(neesOf(error, covariance));
  }
  return {statisticsOf(translations), statisticsOf(rotations), statisticsOf(nees)};
}

}  // namespace kestrel
