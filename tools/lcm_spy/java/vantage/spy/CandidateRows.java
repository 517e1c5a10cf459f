package vantage.spy;

import java.util.ArrayList;
import java.util.Comparator;
import java.util.List;
import vantage.next_view_t;
import vantage.view_candidate_t;

/** NEXT_VIEW as a table: the chosen view first, then the others by what they promise. */
final class CandidateRows {
  private CandidateRows() {}

  static List<Rows> of(next_view_t message, long nowUtime) {
    boolean chosen = message.selected >= 0 && message.selected < message.num_candidates;
    Rows rows = new Rows(
        "Decision " + message.seq + " by " + Text.line(message.criterion) + ": "
            + (chosen ? "view " + message.selected : "no view") + ", age "
            + Text.age(message.utime, nowUtime) + ". " + Text.line(message.reason),
        "view", "chosen", "gain", "cost, m", "reachable", "why not", "x y z, m", "w x y z");
    List<Integer> order = new ArrayList<>();
    for (int i = 0; i < message.num_candidates; i++) {
      order.add(i);
    }
    order.sort(Comparator.<Integer>comparingInt(i -> i == message.selected ? 0 : 1)
        .thenComparing(i -> gain(message.candidates[i]), Comparator.reverseOrder()));
    for (int i : order) {
      view_candidate_t candidate = message.candidates[i];
      rows.add(
          !candidate.reachable,
          Integer.toString(i),
          i == message.selected ? "chosen" : "",
          Text.number(candidate.gain, 4),
          Text.number(candidate.cost, 3),
          candidate.reachable ? "yes" : "no",
          Text.line(candidate.reason),
          Text.numbers(candidate.trans, 3),
          Text.numbers(candidate.quat, 3));
    }
    return List.of(rows);
  }

  // NaN is less than all.
  private static double gain(view_candidate_t candidate) {
    return Double.isNaN(candidate.gain) ? Double.NEGATIVE_INFINITY : candidate.gain;
  }
}
