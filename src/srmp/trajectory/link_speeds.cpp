#include "srmp/trajectory/link_speeds.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/trajectory/part_bound.hpp"

namespace srmp {

namespace {

constexpr double limit_excess = 1e-6;  // of a limit

}  // namespace

void LinkSpeeds::add(const RobotModel& robot, const Eigen::VectorXd& other_positions,
                     const std::vector<LinkSpeedLimit>& limits, std::size_t first_joint) {
  for (LinkSpeedLimit limit : limits) {
    if (limit.link.empty()) limit.link = robot.end_effector();
    const std::size_t number = robot.link_index(limit.link);
    if (robot.link_support(number) == 0)
      throw InvalidArgument("the speed of link '" + limit.link + "' of robot '" + robot.name() +
                            "' cannot be limited: no planned joint moves it");
    RobotDataPtr data = robot.make_data(other_positions);
    LinkChain chain(robot, *data, number, limit.point);
    links_.push_back({&robot, static_cast<Eigen::Index>(first_joint), static_cast<Eigen::Index>(robot.dof()), number,
                      std::move(limit), std::move(data), std::move(chain)});
  }
}

LinkSpeeds::Sample LinkSpeeds::sample(Link& link, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                                      double time) {
  link.robot->forward(*link.data, q);
  jacobian_.resize(6, link.dof);
  link.robot->jacobian(*link.data, link.link, jacobian_);
  const Eigen::Matrix<double, 6, 1> twist = jacobian_ * velocity;
  const Eigen::Vector3d turning = twist.tail<3>();
  const Eigen::Vector3d point = link.robot->link_pose(*link.data, link.link).linear() * link.limit.point;
  return {time, (twist.head<3>() + turning.cross(point)).norm(), turning.norm()};
}

LinkSpeeds::Sample LinkSpeeds::sample(Link& link, double time) {
  Eigen::VectorXd q(link.dof), velocity(link.dof);
  for (Eigen::Index j = 0; j < link.dof; ++j) {
    const detail::Cubic& cubic = joints_[static_cast<std::size_t>(link.first + j)];
    q[j] = cubic.position(time);
    velocity[j] = cubic.velocity(time);
  }
  return sample(link, q, velocity, time);
}

double LinkSpeeds::use(const Eigen::VectorXd& q, const Eigen::VectorXd& velocity) {
  double largest = 0.0;
  for (Link& link : links_) {
    const Sample at = sample(link, q.segment(link.first, link.dof), velocity.segment(link.first, link.dof), 0.0);
    largest = std::max({largest, at.speed / link.limit.speed, at.angular_speed / link.limit.angular_speed});
  }
  return largest;
}

void LinkSpeeds::add_part(Link& link, const Sample& from, const Sample& to, double start, LinkSpeedUse& worst) {
  const double time = to.time - from.time;
  const std::span<const detail::Cubic> joints(joints_.data() + link.first, static_cast<std::size_t>(link.dof));
  const LinkChain::Curvature curvature = link.chain.curvature(joints, from.time, to.time);
  const PartBound speed{std::max(from.speed, to.speed), curvature.velocity * time * time / 8.0, link.limit.speed};
  const PartBound angular{std::max(from.angular_speed, to.angular_speed),
                          curvature.angular_velocity * time * time / 8.0, link.limit.angular_speed};
  if ((speed.is_known_well(worst.speed) && angular.is_known_well(worst.angular_speed)) ||
      time <= PartBound::smallest_part) {
    speed.raise(worst.speed, worst.speed_time, start + (from.speed > to.speed ? from.time : to.time));
    angular.raise(worst.angular_speed, worst.angular_speed_time,
                  start + (from.angular_speed > to.angular_speed ? from.time : to.time));
    return;
  }
  const Sample middle = sample(link, (from.time + to.time) / 2.0);
  add_part(link, from, middle, start, worst);
  add_part(link, middle, to, start, worst);
}

std::vector<LinkSpeedUse> LinkSpeeds::prove(const Motion& motion) {
  std::vector<LinkSpeedUse> uses;
  for (Link& link : links_) {
    LinkSpeedUse worst{.limit = link.limit};
    std::vector<std::pair<Sample, Sample>> ends(motion.segments);
    for (std::size_t i = 0; i < motion.segments; ++i) {  // first, so that slow parts need not be divided
      const double start = motion.cubics(i, joints_);
      ends[i] = {sample(link, 0.0), sample(link, joints_.front().h)};
      for (const Sample& end : {ends[i].first, ends[i].second}) {
        PartBound{end.speed, 0.0, link.limit.speed}.raise(worst.speed, worst.speed_time, start + end.time);
        PartBound{end.angular_speed, 0.0, link.limit.angular_speed}.raise(worst.angular_speed, worst.angular_speed_time,
                                                                          start + end.time);
      }
    }
    for (std::size_t i = 0; i < motion.segments; ++i) {
      interruption_point();
      const double start = motion.cubics(i, joints_);
      add_part(link, ends[i].first, ends[i].second, start, worst);
    }
    uses.push_back(std::move(worst));
  }
  return uses;
}

LinkSpeeds::Motion LinkSpeeds::motion_of(const Trajectory& motion) {
  const auto cubics = [&motion](std::size_t segment, std::vector<detail::Cubic>& joints) {
    const auto row = static_cast<Eigen::Index>(segment);
    joints.resize(motion.dof());
    for (std::size_t j = 0; j < joints.size(); ++j)
      joints[j] = detail::segment_of(motion, row, static_cast<Eigen::Index>(j));
    return motion.times[row];
  };
  return {.segments = motion.size() > 0 ? motion.size() - 1 : 0, .cubics = cubics};
}

std::vector<LinkSpeedUse> LinkSpeeds::prove(const Trajectory& motion) { return prove(motion_of(motion)); }

double LinkSpeeds::use(const Motion& motion) {
  double largest = 0.0;
  for (const LinkSpeedUse& use : prove(motion)) largest = std::max(largest, use.fraction());
  return largest;
}

double LinkSpeeds::use(const Trajectory& motion) {
  double largest = 0.0;
  for (const LinkSpeedUse& use : prove(motion)) largest = std::max(largest, use.fraction());
  return largest;
}

LinkSpeeds::Motion LinkSpeeds::straight(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double time) {
  const auto cubics = [&a, &b, time](std::size_t, std::vector<detail::Cubic>& joints) {
    joints.resize(static_cast<std::size_t>(a.size()));
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const auto joint = static_cast<Eigen::Index>(j);
      joints[j] = detail::line(a[joint], b[joint], time);
    }
    return 0.0;
  };
  return {.segments = 1, .cubics = cubics};
}

double LinkSpeeds::straight_use(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return use(straight(a, b, 1.0)); }

void add_link_speeds(Certificate& certificate, const Trajectory& motion, LinkSpeeds& speeds, bool faults) {
  certificate.link_speeds = speeds.prove(motion);
  const auto check = [&](const LinkSpeedUse& use, const char* what, double value, double limit, double time,
                         const char* unit) {
    if (value <= limit * (1.0 + limit_excess)) return;
    certificate.faults.push_back({FaultKind::link_speed_limit,
                                  "link '" + use.limit.link + "': the " + what + " reaches up to " + to_text(value) +
                                      unit + " near " + to_text(time) + " s; its limit is " + to_text(limit) + unit,
                                  time});
  };
  if (!faults) return;
  for (const LinkSpeedUse& use : certificate.link_speeds) {
    check(use, "speed", use.speed, use.limit.speed, use.speed_time, " m/s");
    check(use, "angular speed", use.angular_speed, use.limit.angular_speed, use.angular_speed_time, " rad/s");
  }
}

}  // namespace srmp
