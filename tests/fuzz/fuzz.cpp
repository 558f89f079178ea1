// Gives readers what nobody would write. Each case is made of a seed by a few random changes, the same on every
// machine; a case may end with srmp::Error, and must not crash, take longer than 5 s, more than 2 GB, or throw anything
// else. Without arguments: a few seconds of every door.
//
//   fuzz [DOOR ...] [--cases N] [--from K] [--minutes M] [--seeds DIR] [--show]
//
// --minutes is of each door.

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "fuzz/doors.hpp"
#include "srmp/core/error.hpp"
#include "support/amount.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool limits_memory = false;  // it reserves terabytes itself
#else
constexpr bool limits_memory = true;
#endif

namespace {

using fuzz::Door;

constexpr unsigned max_seconds = limits_memory ? 5 : 60;  // a sanitizer makes everything slower
constexpr rlim_t max_memory = rlim_t{3} << 30;            // addresses: 2 GB of data, and the program with its libraries

struct Arguments {
  std::vector<std::string> doors;
  std::size_t cases{0}, from{0};
  double minutes{0.0};
  std::string seeds{SRMP_SOURCE_DIR "/tests/fuzz/seeds"};
  bool show{false};
};

std::string current_door;
std::size_t current_case = 0;

/// Says which case was running. Not async-signal-safe, but the process is lost anyway.
void report(const char* what) {
  std::fprintf(stderr, "\nFAULT %s in '%s', case %zu (fuzz %s --from %zu --cases 1)\n", what, current_door.c_str(),
               current_case, current_door.c_str(), current_case);
}

extern "C" void on_signal(int signal) {
  report(signal == SIGALRM ? "hang" : strsignal(signal));
  _exit(3);
}

std::vector<std::string> seeds_of(const Door& door, const std::string& directory) {
  std::vector<std::filesystem::path> paths;
  if (door.seeds.empty()) return {""};
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    if (entry.path().filename().string().starts_with(door.seeds)) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> seeds;
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  if (seeds.empty()) throw std::runtime_error("no seeds '" + door.seeds + "*' in " + directory);
  return seeds;
}

std::uint64_t number_of(const std::string& name, std::size_t i) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash + i;
}

struct Counts {
  std::size_t cases{}, accepted{}, refused{}, faults{};
};

/// Runs one case; false: it threw what it must not.
bool run_case(const Door& door, const std::vector<std::string>& seeds, bool show, Counts& counts) {
  fuzz::Random random(number_of(door.name, current_case));
  const std::string input = door.seeds.empty() ? "" : door.words ? mutate_words(seeds, random) : mutate(seeds, random);
  if (show) {
    std::printf("%s\n", input.c_str());
    std::fflush(stdout);
  }
  ++counts.cases;
  alarm(max_seconds);
  try {
    door.enter(input, random);
    ++counts.accepted;
  } catch (const srmp::Error& error) {
    ++counts.refused;
    if (const std::string_view said = error.what(); said.size() >= 500 || said.find('\n') != said.npos) {
      report(("not one short sentence: " + std::string(said)).c_str());
      ++counts.faults;
    }
    if (show) std::printf("-> %s\n", error.what());
  } catch (const std::exception& error) {
    report((std::string("exception ") + error.what()).c_str());
    ++counts.faults;
  }
  alarm(0);
  return true;
}

/// Mutations of seeds that nobody reads any more show nothing.
bool accepts_a_seed(const Door& door, const std::vector<std::string>& seeds) {
  constexpr std::size_t tries = 20;
  for (std::size_t i = 0; i < tries * seeds.size(); ++i) try {
      fuzz::Random random(i);
      door.enter(seeds[i % seeds.size()], random);
      return true;
    } catch (const srmp::Error&) {
    }
  return false;
}

Counts run_door(const Door& door, const Arguments& arguments, double seconds) {
  const auto seeds = seeds_of(door, arguments.seeds);
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const std::size_t end = arguments.cases ? arguments.from + arguments.cases : amount(door.cases);
  Counts counts;
  current_door = door.name;
  if (!accepts_a_seed(door, seeds)) {
    report("no seed is accepted");
    ++counts.faults;
  }
  for (current_case = arguments.from; seconds > 0 ? elapsed() < seconds : current_case < end; ++current_case)
    run_case(door, seeds, arguments.show, counts);
  std::printf("%-16s %9zu cases %9zu accepted %9zu refused %4zu faults  %7.1f s\n", door.name.c_str(), counts.cases,
              counts.accepted, counts.refused, counts.faults, elapsed());
  std::fflush(stdout);
  return counts;
}

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto value = [&] { return i + 1 < argc ? argv[++i] : throw std::runtime_error(argument + " needs a value"); };
    if (argument == "--cases")
      arguments.cases = std::strtoull(value(), nullptr, 10);
    else if (argument == "--from")
      arguments.from = std::strtoull(value(), nullptr, 10);
    else if (argument == "--minutes")
      arguments.minutes = std::strtod(value(), nullptr);
    else if (argument == "--seeds")
      arguments.seeds = value();
    else if (argument == "--show")
      arguments.show = true;
    else
      arguments.doors.push_back(argument);
  }
  return arguments;
}

int run(const Arguments& arguments) {
  const std::filesystem::path in_memory = "/dev/shm";  // many times faster than a disk
  const auto base = std::filesystem::is_directory(in_memory) ? in_memory : std::filesystem::temp_directory_path();
  std::string directory = (base / "srmp_fuzz_XXXXXX").string();
  if (!mkdtemp(directory.data())) throw std::runtime_error("no temporary directory");
  std::vector<Door> doors = fuzz::all_doors(directory);
  if (!arguments.doors.empty())
    std::erase_if(doors, [&](const Door& door) {
      return std::find(arguments.doors.begin(), arguments.doors.end(), door.name) == arguments.doors.end();
    });
  if (doors.empty()) throw std::runtime_error("no such door");
  const double seconds = 60.0 * arguments.minutes;
  std::size_t cases = 0, faults = 0;
  for (const Door& door : doors) {
    const Counts counts = run_door(door, arguments, seconds);
    cases += counts.cases;
    faults += counts.faults;
  }
  std::filesystem::remove_all(directory);
  std::printf("%zu cases, %zu faults\n", cases, faults);
  return faults == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  for (const int signal : {SIGALRM, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
    if (limits_memory || signal == SIGALRM) std::signal(signal, on_signal);
  if (limits_memory) {
    const rlimit limit{max_memory, max_memory};
    setrlimit(RLIMIT_AS, &limit);
  }
  try {
    return run(parse(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz: %s\n", error.what());
    return 2;
  }
}
