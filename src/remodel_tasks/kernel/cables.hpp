// The cables of which a list under construction has cores, and the cores that are left of each.
//
// A plan pays for each pick that begins a cable, once for each at least, so that the penalty of a
// plan would have a greedy construction begin all cables last. It is charged here where a cable is
// left unfinished, taken up again, or begun by an arm that cannot pick all its cores.
#pragma once

#include <algorithm>
#include <vector>

#include "problem.hpp"

namespace remodel {

class BegunCables {
 public:
  explicit BegunCables(const Problem& problem) : p_(problem) {
    int cables = 0;
    for (int wire = 0; wire < p_.t.wires; ++wire) cables = std::max(cables, p_.t.cable[wire] + 1);
    for (int arm = 0; arm < p_.t.arms; ++arm) cables = std::max(cables, p_.t.arm_cable[arm] + 1);
    left_.assign(cables, 0);
    begun_.assign(cables, 0);
    able_.assign(cables, kBoth);
    for (int wire = 0; wire < p_.t.wires; ++wire)
      if (p_.t.cable[wire] >= 0) {
        ++left_[p_.t.cable[wire]];
        able_[p_.t.cable[wire]] &= arms_of(wire);
      }
    for (int arm = 0; arm < p_.t.arms; ++arm)
      if (p_.t.arm_cable[arm] >= 0) begun_[p_.t.arm_cable[arm]] = 1;
  }

  // What it costs that an arm picks a wire next, after one of a cable, or of none (-1).
  int penalty(int arm, int last, int wire) const {
    const int cable = p_.t.cable[wire];
    if (cable == last) return 0;
    const bool leaves = last >= 0 && left_[last] > 0, returns = cable >= 0 && begun_[cable];
    const bool must_leave = cable >= 0 && !(able_[cable] >> arm & 1);
    return p_.t.cable_weight * (leaves + returns + must_leave);
  }

  void take(int wire) {
    const int cable = p_.t.cable[wire];
    if (cable < 0) return;
    --left_[cable];
    begun_[cable] = 1;
  }

 private:
  static constexpr int kBoth = 3;

  // The arms, as bits, that may pick a wire.
  int arms_of(int wire) const {
    const int modes = p_.t.modes[wire];
    return ((modes & 0x0f) != 0) | ((modes & 0xf0) != 0) << 1;
  }

  const Problem& p_;
  std::vector<int> left_, able_;
  std::vector<char> begun_;
};

}  // namespace remodel
