// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/experiments/kidnapping.h"
#include "kestrel_slam/experiments/relocalization_measurement.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/simulation/random_office.h"

namespace kestrel {
namespace {

constexpr std::size_t kKidnappings = 100;

struct Options {
  std::vector<std::string> recordings, others;
  std::size_t step = 20;
  double travel_m = 2.0;
  std::string trials;
  bool search = true, localize = true;
  std::optional<std::size_t> kidnappings;
  std::size_t strangers = 0, gaps = 0;
  std::vector<std::string> worlds;
};

/// A place for simulated flights. Throws std::invalid_argument if there is none of this name.
Place worldCalled(const std::string& name) {
  constexpr std::size_t kRooms = 12;
  return name == "office" ? randomOffice(1, OfficeChange::kNone, 0, kRooms) : place(name);
}

struct Log {
  std::string name;
  std::vector<PlacedScan> scans;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

/// One row of the table.
struct Row {
  std::size_t scans = 0, in_map = 0, right = 0, ambiguous = 0, unknown = 0, false_accepts = 0;
  std::vector<double> seconds, work;
  std::size_t memory_bytes = 0;

  void add(const RelocalizationTrial& trial, bool same_building) {
    ++scans;
    const bool right_one = trial.isFound() && trial.isRight() && same_building;
    false_accepts += trial.isFound() && !right_one ? 1U : 0U;
    seconds.insert(seconds.end(), trial.seconds.begin(), trial.seconds.end());
    work.push_back(static_cast<double>(trial.answer.work) * 1e-6);
    memory_bytes = std::max(memory_bytes, trial.memory_bytes);
    if (!same_building || !trial.in_map) return;
    ++in_map;
    right += right_one ? 1 : 0;
    ambiguous += trial.answer.state == RelocalizationState::kAmbiguous ? 1 : 0;
    unknown += trial.answer.state == RelocalizationState::kUnknown ? 1 : 0;
  }

  void print(const std::string& map, const std::string& from, const char* kind) const {
    std::printf(
        "| %s | %s | %s | %zu | %zu | %.1f | %zu | %zu | %zu | %.2f | %.2f | %.0f | %.0f | "
        "%.0f |\n",
        map.c_str(), from.c_str(), kind, scans, in_map,
        in_map == 0 ? 0.0 : 100.0 * static_cast<double>(right) / static_cast<double>(in_map),
        ambiguous, unknown, false_accepts, quantile(seconds, 0.5), quantile(seconds, 0.99),
        quantile(work, 0.5), quantile(work, 0.99), static_cast<double>(memory_bytes) * 1e-6);
    std::fflush(stdout);
  }
};

std::string textOf(const PlaceHypothesis& place) {
  char text[200];
  const WallAgreement& walls = place.walls;
  std::snprintf(text, sizeof text, "%.3f,%.3f,%.4f,%zu,%zu,%zu,%zu,%.3f,%.3f", place.match.score,
                place.match.known, place.match.constraint, walls.hits, walls.known, walls.matched,
                walls.crossed, walls.contradiction(), place.score());
  return text;
}

constexpr char kColumns[] =
    "map,scans,stamp,state,reason,in_map,right,true_known,true_fit,error_m,error_deg,fit,known,"
    "constraint,squares,known_squares,matched,crossed,contradiction,score,"
    "margin,agreement,places,travel_m,work,second_m,second_deg,second_fit,second_known,second_"
    "constraint,second_squares,second_known_squares,second_matched,second_crossed,second_"
    "contradiction,second_score\n";

void list(std::FILE* file, const std::string& map, const std::string& from,
          const RelocalizationTrial& t, bool same_building) {
  if (file == nullptr) return;
  std::vector<PlaceHypothesis> places = t.answer.hypotheses;
  const std::size_t count = places.size();
  places.resize(std::max<std::size_t>(2, count));
  const Pose2 between = places[0].match.pose.between(places[1].match.pose);
  std::fprintf(
      file, "%s,%s,%.6f,%s,%s,%d,%d,%.3f,%.3f,%.3f,%.2f,%s,%.3f,%.2f,%zu,%.2f,%lld,%.2f,%.1f,%s\n",
      map.c_str(), from.c_str(), t.stamp, toString(t.answer.state), t.answer.reason,
      t.in_map && same_building, t.isRight() && same_building, t.known, t.fit, t.error_m,
      t.error_deg, textOf(places[0]).c_str(), t.answer.margin, t.answer.agreement, count,
      t.travel_m, static_cast<long long>(t.answer.work), between.distance(), radToDeg(between.yaw),
      textOf(places[1]).c_str());
  std::fflush(file);
}

void measure(const Options& options, const Log& own, const std::vector<Log>& logs,
             std::FILE* trials) {
  const RelocalizationMap map(own.scans, 0, own.scans.size() / 2);
  for (const Log& log : logs) {
    const bool same = log.name == own.name;
    const std::size_t first = same ? log.scans.size() / 2 : 0;
    const std::size_t step = same ? options.step : 5 * options.step;
    Row single, moved;
    for (std::size_t i = first; i < log.scans.size(); i += step) {
      const RelocalizationTrial alone = map.locate(log.scans[i]);
      single.add(alone, same);
      list(trials, own.name, log.name, alone, same);
    }
    single.print(own.name, log.name, "single scan");
    if (options.travel_m <= 0.0) continue;
    for (std::size_t i = first; i < log.scans.size(); i += step) {
      const RelocalizationTrial moving = map.follow(log.scans, i, options.travel_m);
      moved.add(moving, same);
      list(trials, own.name, log.name, moving, same);
    }
    moved.print(own.name, log.name, "with motion");
  }
}

/// Searches for scans of all other recordings in the map of one whole recording.
void measureStrangers(const Options& options, const Log& own, const std::vector<Log>& logs,
                      std::FILE* trials) {
  const RelocalizationMap map(own.scans, 0, own.scans.size());
  Row row;
  for (const Log& log : logs) {
    if (log.name == own.name) continue;
    const std::size_t count = std::min(options.strangers, log.scans.size());
    for (std::size_t i = 0; i < count; ++i) {
      const PlacedScan& scan = log.scans[(2 * i + 1) * log.scans.size() / (2 * count)];
      const RelocalizationTrial trial = map.locate(scan);
      row.add(trial, false);
      list(trials, own.name, log.name, trial, false);
    }
  }
  row.print(own.name, "all others", "single scan");
}

void printLocalization(const Log& log, const LocalizationTrial& trial, const std::string& file,
                       const char* kind) {
  std::printf(
      "%s: second half in the %s of the first: %zu scans, %zu lost, %zu wrong; distance "
      "from the trajectory with loops %.4f m, at most %.3f m; %.2f s, mapping %.2f s",
      log.name.c_str(), kind, trial.scans, trial.lost, trial.wrong, trial.mean_m, trial.max_m,
      trial.seconds, trial.mapping_seconds);
  std::error_code error;
  if (!file.empty() && std::filesystem::exists(file, error)) {
    Trajectory both;
    const double begin = trial.trajectory.empty() ? 0.0 : trial.trajectory.front().stamp;
    for (std::size_t i = 0; i < log.scans.size() / 2; ++i)
      both.push_back({log.scans[i].scan.stamp, log.scans[i].pose});
    both.insert(both.end(), trial.trajectory.begin(), trial.trajectory.end());
    std::vector<Relation> across;
    for (const Relation& relation : readRelations(file)) {
      if ((relation.stamp1 < begin) != (relation.stamp2 < begin)) across.push_back(relation);
    }
    const ErrorStatistics of = evaluateRelations(both, across).all.translation_m;
    std::printf("; %zu relations across: %.4f m, at most %.3f m", of.count, of.mean, of.max);
  }
  std::puts("");
  std::fflush(stdout);
}

/// Scans of the second half in a fixed sequence that visits all places, and for each another one.
/// `attempt` tries one and returns whether it counts. Returns how many count.
std::size_t visitPlaces(
    const Log& log, std::size_t count,
    const std::function<bool(std::size_t from, std::size_t to, std::size_t number)>& attempt) {
  const std::size_t half = log.scans.size() / 2, room = half - half / 8;
  std::size_t trials = 0;
  for (std::size_t n = 0; trials < count && n < 50 * count; ++n) {
    if (attempt(half + n * 7919 % room + 1, half + n * 104729 % room + 1, trials)) ++trials;
  }
  return trials;
}

/// Carries the vehicle from place to place of the second half, 5 to 40 m away.
void printKidnapping(const Log& log, const RelocalizationMap& map, std::size_t count) {
  KidnapSummary sum;
  visitPlaces(log, count, [&](std::size_t from, std::size_t to, std::size_t number) {
    const double away = log.scans[from].pose.between(log.scans[to].pose).distance();
    if (away < kLeastKidnapM || away > kMostKidnapM || !map.isKnown(log.scans[from]) ||
        !map.isKnown(log.scans[to]))
      return false;
    const double covered_s = number % 4 == 3 ? 0.0 : 2.0;
    const KidnapTrial trial = map.kidnap(log.scans, from, to, covered_s, kKidnapTravelM);
    sum.add(trial);
    return true;
  });
  std::printf("%s, a quarter of the time in no time: %s\n", log.name.c_str(), sum.text().c_str());
  std::fflush(stdout);
}

/// The same in simulated flights.
void printSimulatedKidnapping(const std::string& world, std::size_t count) {
  const KidnappedFlights flights(worldCalled(world));
  KidnapSummary sum;
  for (std::uint64_t n = 0; sum.trials < count && n < 50 * count; ++n) {
    const std::optional<KidnapTrial> trial = flights.fly(n);
    if (!trial) continue;
    sum.add(*trial);
  }
  std::printf("%s, simulated flights: %s\n", world.c_str(), sum.text().c_str());
  std::fflush(stdout);
}

/// Leaves out the scans of 0.2 to 4 s at places of the second half.
void printGaps(const Log& log, std::size_t count) {
  const RelocalizationMap map(log.scans, 0, log.scans.size() / 2);
  std::size_t wrong_trials = 0;
  GapTrial sum;
  const auto attempt = [&](std::size_t from, std::size_t /*to*/, std::size_t number) {
    if (!map.isKnown(log.scans[from])) return false;
    const GapTrial trial =
        map.followOverGap(log.scans, from, 0.2 * static_cast<double>(1 + number % 20));
    wrong_trials += trial.wrong > 0 ? 1 : 0;
    sum.scans += trial.scans;
    sum.lost += trial.lost;
    sum.wrong += trial.wrong;
    return true;
  };
  const std::size_t trials = visitPlaces(log, count, attempt);
  std::printf(
      "%s: %zu gaps of 0.2 to 4 s: of %zu scans after them %zu lost, %zu wrong and not "
      "said to be lost, after %zu gaps\n",
      log.name.c_str(), trials, sum.scans, sum.lost, sum.wrong, wrong_trials);
  std::fflush(stdout);
}

void measureLocalization(const Options& options, const Log& log, const std::string& path) {
  const std::size_t kidnappings = options.kidnappings.value_or(options.localize ? kKidnappings : 0);
  if (!options.localize && kidnappings == 0) return;
  const RelocalizationMap map(log.scans, 0, log.scans.size() / 2);
  std::string relations = path.substr(0, path.rfind(".clf")) + ".relations";
  const std::size_t half = log.scans.size() / 2, end = log.scans.size();
  if (options.localize) {
    printLocalization(log, map.localize(log.scans, half, end, false), relations, "map");
    printLocalization(log, map.localize(log.scans, half, end, true), relations, "pgm file");
  }
  if (kidnappings > 0) printKidnapping(log, map, kidnappings);
}

void run(const Options& options) {
  for (const std::string& world : options.worlds)
    printSimulatedKidnapping(world, options.kidnappings.value_or(kKidnappings));
  if (options.recordings.empty()) return;
  std::FILE* trials = options.trials.empty() ? nullptr : std::fopen(options.trials.c_str(), "w");
  if (trials == nullptr && !options.trials.empty())
    throw std::runtime_error(options.trials + ": cannot be written");
  if (trials != nullptr) std::fputs(kColumns, trials);
  std::vector<Log> logs;
  for (const std::string& path : options.recordings)
    logs.push_back({nameOf(path), placeScans(path)});
  std::puts(
      "| map | scans of | query | queries | in the map | right, % of those | ambiguous | unknown | "
      "false accepts | p50, s | p99, s | p50, M work | p99, M work | MB above the map |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
  const std::size_t maps = logs.size();
  for (const std::string& path : options.others) logs.push_back({nameOf(path), placeScans(path)});
  for (std::size_t m = 0; m < maps && options.search; ++m) measure(options, logs[m], logs, trials);
  for (std::size_t m = 0; m < maps && options.strangers > 0; ++m)
    measureStrangers(options, logs[m], logs, trials);
  for (std::size_t m = 0; m < maps; ++m)
    measureLocalization(options, logs[m], options.recordings[m]);
  for (std::size_t m = 0; m < maps && options.gaps > 0; ++m) printGaps(logs[m], options.gaps);
  if (trials != nullptr) std::fclose(trials);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app(
      "Measures how well a vehicle is found in a map if nothing is known about its pose. The map "
      "is "
      "the first half of each recording, the queries are scans of its second half and scans of the "
      "other recordings, which must be refused.\n"
      "The truth is the trajectory of the whole recording after loop closing. A place is in the "
      "map "
      "if 60 % of the hits of the scan are in its known part at the true pose. Right: within 0.5 m "
      "and 5 degrees.\n"
      "Exit code 0: done; 1: bad input; 2: wrong usage.");
  app.add_option("RECORDING", options.recordings, "recordings of different buildings");
  app.add_option("--world", options.worlds,
                 "built-in worlds, or office: the vehicle is carried away in simulated flights");
  app.add_option("--others", options.others, "more recordings, whose scans are only queries");
  app.add_option("--step", options.step,
                 "every so many scans one is searched for; of another "
                 "recording, every fifth of those")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--travel", options.travel_m,
                 "search also while the vehicle moves on by this distance, m; 0: not")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--strangers", options.strangers,
                 "search in the map of each whole recording for so many scans of every other "
                 "recording, which must be refused")
      ->capture_default_str();
  app.add_option("--trials", options.trials, "write a table of all searches to this file");
  app.add_option("--search", options.search, "1: measure the search")->capture_default_str();
  app.add_option("--localize", options.localize,
                 "1: localize the second half in the map of the first; relations are read from the "
                 "file with the ending .relations beside the recording")
      ->capture_default_str();
  app.add_option("--kidnappings", options.kidnappings,
                 "how often the vehicle is carried away (100)");
  app.add_option("--gaps", options.gaps, "how often the scans of 0.2 to 4 s are left out")
      ->capture_default_str();
  app.callback([&] {
    if (options.recordings.empty() && options.worlds.empty())
      throw CLI::RequiredError("RECORDING or --world");
  });
  return runTool("measure_relocalization", app, argc, argv, [&] { run(options); });
}
