#pragma once

#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace muster::tools::audit {

struct Place {
  double x_m = 0;
  double y_m = 0;
  bool operator==(const Place&) const = default;
};

/// Metres between two places in a straight line.
double Apart(Place a, Place b);

/// How agents travel, by the audit's own arithmetic: every length of a way and every place on one
/// that the audit computes comes from here. This class is the plain case, straight lines.
class Ways {
 public:
  virtual ~Ways() = default;
  /// Metres from one place to the other for an agent of that class; never less than Apart.
  virtual double Length(int kind, Place from, Place to) const;
  /// Metres that an agent has made from one place to the other, where it is: straight where no way
  /// leads there, as for a UAV that leaves a zone.
  double Gone(int kind, Place from, Place to) const;
  /// The place after that part (0 to 1) of the way.
  virtual Place After(int kind, Place from, Place to, double part) const;
  /// The parts of the way after which it turns.
  virtual std::vector<double> TurnsOf(int kind, Place from, Place to) const;
  /// Metres by which two right answers may differ, because ways are put together of rounded parts.
  virtual double rounding_m(int kind) const;
  /// Where a move to no site ends that was sent to that place, and the number of that stop; -1:
  /// stops have no numbers, and it ends where it was sent to.
  virtual std::pair<Place, int> StopNear(int kind, Place wanted) const;
  /// The stop of that number.
  virtual std::optional<Place> StopOf(int kind, int number) const;
  /// After what part of the way, not before that one, it comes to one of those roads, or into a
  /// zone of the ways that hold `now`; none: it can be gone to its end.
  virtual std::optional<double> MeetsAt(int kind, Place from, Place to, double part,
                                        const std::set<int>& roads, const Ways& now) const;
};

/// The ways of a scenario that says nothing of them: straight ones.
std::shared_ptr<const Ways> DefaultWays();

/// For tests: as long as it lives, DefaultWays() is what it was given.
class ScopedDefaultWays {
 public:
  explicit ScopedDefaultWays(std::shared_ptr<const Ways> ways);
  ~ScopedDefaultWays();
  ScopedDefaultWays(const ScopedDefaultWays&) = delete;
  ScopedDefaultWays& operator=(const ScopedDefaultWays&) = delete;

 private:
  std::shared_ptr<const Ways> before_;
};

}  // namespace muster::tools::audit
