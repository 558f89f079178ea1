#include "srmp/planning/options/other_vocabularies.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace srmp {

namespace {

/// Several words of others, separated by spaces, and what is said of them.
struct Words {
  std::string_view words, meaning;
};

constexpr std::array kOptions{
    Words{"allowedplanningtime planningtime maxplanningtime planningtimeout timeout maxtime solvetime "
          "planningtimelimit maxplantime plantimeout",
          "it is 'time_limit' here [s]"},
    Words{"numplanningattempts planningattempts maxattempts numattempts attempts retries maxretries numtrials",
          "each plan is one attempt here, because the result is deterministic; 'improve_rounds' of 'auto' looks for "
          "shorter paths"},
    Words{
        "maxvelocityscalingfactor velocityscalingfactor maxvelocityscaling velscale velocityfactor timedilationfactor",
        "it is 'velocity_scaling' here"},
    Words{"maxaccelerationscalingfactor accelerationscalingfactor maxaccelerationscaling accscale accelerationfactor",
          "it is 'acceleration_scaling' here"},
    Words{"plannername planner plannertype algorithm plannerconfig pipelineid planningpipeline plannerconfiguration "
          "solver",
          "it is 'planner_id' here"},
    Words{"simplify simplifysolutions simplifysolution simplifypath smooth smoothing smoothpath hybridize interpolate "
          "shortcutting shortenpath",
          "it is 'shortcut' here"},
    Words{
        "timestep dt timesteps interpolationdt interpolationtimestep resampledt samplingtime sampletime controlperiod",
        "it is 'sample_period' here [s]"},
    Words{"epsilon eps suboptimality suboptimalitybound inflation heuristicweight initialepsilon startepsilon",
          "it is 'weight' here"},
    Words{"finalepsilon", "it is 'final_weight' here"},
    Words{"epsilondelta epsdelta epsilondecrement", "it is 'weight_delta' here"},
    Words{"seed randomseed rngseed", "there is nothing to seed here, because results are deterministic"},
    Words{
        "longestvalidsegmentfraction longestvalidsegmentlength collisioncheckresolution collisioncheckingresolution "
        "edgeresolution collisionresolution validitycheckingresolution maxsegmentlength stepsize",
        "motions are proved free between samples here, which needs no such step; 'resolution' is that of the lattice"},
    Words{"range rrtrange maxdistance goalbias delaycc maxnearestneighbors intermediatestates",
          "planners that sample have nothing to tune here; 'auto' chooses between them and searches"},
    Words{"optimizationobjective objective", "cost is the length of the path in joint space here"},
    Words{"maxiterations maxiters iterations maxnodes maxsamples terminationcondition",
          "plans end by 'time_limit' here [s]"},
    Words{"goaltolerance goaljointtolerance goalpositiontolerance goalorientationtolerance positiontolerance "
          "orientationtolerance rotationtolerance tolerance positionthreshold rotationthreshold",
          "tolerances belong to the goal here: GoalConstraint's position_tolerance and rotation_tolerance"},
    Words{"numikseeds ikseeds numseeds ikattempts iktimeout kinematicssolverattempts kinematicssolvertimeout maxik "
          "ikinitqposnum ninitqpos",
          "it is 'ik_solutions' here"},
    Words{"startstatemaxdt startstatemaxboundserror fixstartstate jigglefraction fixjointlimits",
          "it is 'recover_start' here"},
    Words{"workspaceparameters workspacebounds groupname startstate goalconstraints pathconstraints",
          "it is no option of a planner here; apply_moveit_request reads whole MoveIt requests"},
    Words{"threads nthreads numworkers workers ncores maxthreads",
          "it is 'num_threads' here, of planners that have it"},
    Words{"jerklimit maxjerk maxvelocity maxacceleration velocitylimits accelerationlimits jointvelocitylimit",
          "limits belong to the robot here: set_motion_limits and load_joint_limits"},
};

constexpr std::array kPlanners{
    Words{"rrtconnectkconfigdefault geometric::rrtconnect rrtkconfigdefault birrt bidirectionalrrt",
          "it is 'RRTConnect' here"},
    Words{"rrtstar rrt* rrtstarkconfigdefault prm prm* prmstar prmkconfigdefault prmstarkconfigdefault bitstar bit* "
          "abitstar "
          "abit* aitstar ait* informedrrtstar informedrrt* fmt fmt* bfmt bfmtkconfigdefault fmtkconfigdefault trrt "
          "trrtkconfigdefault est estkconfigdefault biest kpiece kpiecekconfigdefault bkpiece bkpiecekconfigdefault "
          "lbkpiece lbkpiecekconfigdefault sbl sblkconfigdefault stride lazyprm lazyprmstar spars sparstwo pdst "
          "anytimepathshortening "
          "eitstar eit* cforest",
          "it is a planner of OMPL; 'auto' is the quickest here, with improve_rounds or improve_time it shortens its "
          "path"},
    Words{"chomp stomp trajopt ompl curobo vamp motiongen gpmp2",
          "it is another library; 'auto' is the quickest planner here"},
    Words{"ptp lin circ pilzindustrialmotionplanner", "Cartesian and point-to-point motions do not exist here yet"},
    Words{"mgs", "it is a planner of the package srmp of PyPI; 'auto' chooses among the planners here"},
    Words{"dijkstra", "'Astar' with its heuristic finds the same path here"},
    Words{"default", "'auto' is the default here"},
};

/// Upper case, '-', '_' and ' ' do not count.
std::string plain(std::string_view word) {
  std::string text;
  for (const char c : word)
    if (c != '-' && c != '_' && c != ' ') text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool has_word(std::string_view words, std::string_view word) {
  const auto enclosed = [](std::string_view text) { return std::string(" ").append(text) + " "; };
  return !word.empty() && enclosed(words).find(enclosed(word)) != std::string::npos;
}

template <std::size_t n>
std::string meaning(const std::array<Words, n>& entries, const std::string& word) {
  const std::string text = plain(word);
  for (const Words& entry : entries)
    if (has_word(entry.words, text)) return std::string(entry.meaning);
  return {};
}

}  // namespace

std::string option_of_other_planner(const std::string& key) { return meaning(kOptions, key); }

std::string planner_of_other_library(const std::string& id) { return meaning(kPlanners, id); }

}  // namespace srmp
