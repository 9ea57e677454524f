#include "two_arm_greedy.hpp"

#include <limits>

#include "cables.hpp"

namespace remodel {
namespace {

struct ArmClock {
  Point at;
  int free, tool, colour, cable, zone;
};

struct Choice {
  Cost cost = std::numeric_limits<Cost>::max();
  std::size_t ready = 0;
  int mode = 0;
  int given = 0, done = 0, routed = 0;   // times [tick]
};

class Builder {
 public:
  Builder(const Problem& problem, int light_surcharge, bool by_rank)
      : p_(problem), light_surcharge_(light_surcharge), by_rank_(by_rank),
        light_(problem.t.light_started), waiting_(problem.t.wires), routed_(problem.t.wires),
        delays_(problem.t.wires), cables_(problem),
        torn_(p_.t.cable_weight > 0 ? p_.t.cable_weight : std::numeric_limits<Cost>::max()) {
    if (by_rank_)
      for (const Ranking& ranking : p_.rankings) ranking.add_delays(delays_);
    for (int arm = 0; arm < 2; ++arm)
      arms_[arm] = {p_.start(arm), 0, p_.t.arm_tool[arm], p_.t.arm_colour[arm], p_.t.arm_cable[arm],
                    p_.t.arm_zone[arm]};
    for (int wire = 0; wire < p_.t.wires; ++wire) {
      waiting_[wire] = static_cast<int>(p_.before[wire].size());
      if (!waiting_[wire]) ready_.push_back(wire);
    }
  }

  ListPlan build() {
    take_opening();
    while (!ready_.empty()) {
      const int arm = arms_[1].free < arms_[0].free;
      Choice choice = best_for(arm);
      // Rather the other arm's next wire than a cable torn apart.
      if (choice.cost >= torn_) {
        const Choice other = best_for(1 - arm);
        if (other.cost < choice.cost) choice = other;
      }
      take(choice);
    }
    return plan_;
  }

 private:
  void take_opening() {
    for (int i = 0; i < p_.t.openings; ++i) {
      const std::size_t at = std::find(ready_.begin(), ready_.end(), p_.t.opening[i]) - ready_.begin();
      Choice best;
      for (int mode = 0; mode < 8; ++mode)
        if (p_.has_mode(ready_[at], mode)) {
          const Choice choice = estimate(at, mode);
          if (choice.cost < best.cost) best = choice;
        }
      take(best);
    }
  }

  Choice best_for(int arm) const {
    Choice best;
    for (std::size_t i = 0; i < ready_.size(); ++i)
      for (int mode = 4 * arm; mode < 4 * arm + 4; ++mode)
        if (p_.has_mode(ready_[i], mode)) {
          const Choice choice = estimate(i, mode);
          if (choice.cost < best.cost) best = choice;
        }
    return best;
  }

  // What a wire would cost as the next one: idle time and ways of the arms, and penalties.
  Choice estimate(std::size_t index, int mode) const {
    const int wire = ready_[index], arm = Mode::arm(mode), first = Mode::first(mode);
    const ArmClock& giver = arms_[arm];
    Choice choice;
    choice.ready = index;
    choice.mode = mode;
    const int way = way_to_pick(arm, wire) + p_.travel(p_.slot(wire), p_.end(wire, first));
    int order = 0;
    for (int before : p_.under[wire]) order = std::max(order, routed_[before]);
    const int could = giver.free + way + p_.t.pick[wire] + p_.t.insert[2 * wire + first];
    const int route = std::max(could, order);
    const int finish = p_.t.insert[2 * wire + 1 - first] + p_.t.fix[wire];
    choice.cost = way + (route - could) + penalty(arm, wire);
    if (!Mode::hands_over(mode)) {
      choice.routed = route + p_.t.route[wire];
      choice.given = choice.done = choice.routed + finish;
      return choice;
    }
    const ArmClock& receiver = arms_[1 - arm];
    const int brought = route + p_.t.handover_route[2 * wire + first];
    const int came = receiver.free + way_to(1 - arm, p_.handover(wire), p_.t.tool[wire]);
    choice.cost += std::abs(brought - came) + (came - receiver.free);
    choice.given = std::max(brought, came) + p_.t.hand_over;
    choice.routed = choice.given + p_.t.handover_route[2 * wire + 1 - first];
    choice.done = choice.routed + finish;
    return choice;
  }

  int way_to(int arm, Point to, int tool) const {
    const ArmClock& a = arms_[arm];
    if (a.tool == tool) return p_.travel(a.at, to);
    return p_.travel(a.at, p_.station(arm)) + p_.t.change_tool + p_.t.tool_weight +
           p_.travel(p_.station(arm), to);
  }

  int way_to_pick(int arm, int wire) const {
    return p_.t.stage[wire] == kStored ? way_to(arm, p_.slot(wire), p_.t.tool[wire]) : 0;
  }

  Cost penalty(int arm, int wire) const {
    const ArmClock& a = arms_[arm];
    Cost cost = delays_[wire] + cables_.penalty(arm, a.cable, wire);
    if (a.colour >= 0)
      cost += p_.t.colour_weight * (a.colour != p_.t.colour[wire]) +
              p_.t.zone_weight * std::max(0, a.zone - p_.t.zone[wire]);
    else if (arm == 0)
      cost += p_.t.start_weight * p_.t.zone[wire];
    if (p_.t.preferred_arm[wire] >= 0 && p_.t.preferred_arm[wire] != arm) cost += p_.t.arm_weight;
    if (!light_ && !p_.t.heavy[wire]) cost += light_surcharge_;
    return cost;
  }

  void take(const Choice& choice) {
    const int wire = ready_[choice.ready], arm = Mode::arm(choice.mode);
    const int second = 1 - Mode::first(choice.mode);
    ready_[choice.ready] = ready_.back();
    ready_.pop_back();
    plan_.order.push_back(wire);
    plan_.modes.push_back(choice.mode);
    routed_[wire] = choice.routed;
    cables_.take(wire);
    light_ = light_ || !p_.t.heavy[wire];
    if (by_rank_)
      for (const Ranking& ranking : p_.rankings) ranking.take_off_delays(wire, delays_);
    arms_[arm].colour = p_.t.colour[wire];
    arms_[arm].cable = p_.t.cable[wire];
    arms_[arm].zone = p_.t.zone[wire];
    ArmClock& finisher = arms_[Mode::hands_over(choice.mode) ? 1 - arm : arm];
    arms_[arm].free = choice.given;
    arms_[arm].at = p_.handover(wire);
    finisher.free = choice.done;
    finisher.at = p_.end(wire, second);
    arms_[arm].tool = finisher.tool = p_.t.tool[wire];
    for (int next : p_.after[wire])
      if (!--waiting_[next]) ready_.push_back(next);
  }

  const Problem& p_;
  const int light_surcharge_;
  const bool by_rank_;
  bool light_;
  ArmClock arms_[2];
  std::vector<int> ready_, waiting_, routed_;
  std::vector<Cost> delays_;
  BegunCables cables_;
  const Cost torn_;   // a choice that costs as much tears a cable apart, or is none
  ListPlan plan_;
};

}  // namespace

ListPlan greedy_list(const Problem& problem, int light_surcharge, bool by_rank) {
  return Builder(problem, light_surcharge, by_rank).build();
}

}  // namespace remodel
