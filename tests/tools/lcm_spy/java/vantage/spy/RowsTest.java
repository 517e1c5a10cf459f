package vantage.spy;

import java.util.List;
import vantage.channel_status_t;
import vantage.next_view_t;
import vantage.process_status_t;
import vantage.stage_status_t;
import vantage.view_candidate_t;

/** Text, rates and the order of lists. */
public final class RowsTest {
  private static final long SECOND_NS = 1_000_000_000L;

  private RowsTest() {}

  public static void main(String[] arguments) throws IllegalAccessException {
    Check.runAll(RowsTest.class);
  }

  static void testNumbersAreShort() {
    Check.equal(Text.number(1.23456, 3), "1.235");
    Check.equal(Text.number(Double.NaN, 3), "nan");
    Check.equal(Text.number(Double.NEGATIVE_INFINITY, 3), "-inf");
    Check.equal(Text.number(1e300, 3), "1.000e+300");
    Check.equal(Text.numbers(new double[] {1, -0.5}, 1), "1.0 -0.5");
  }

  static void testDurationsHaveTheUnitThatSuits() {
    Check.equal(Text.duration(0.25), "0.3 s");
    Check.equal(Text.duration(240), "4 min");
    Check.equal(Text.duration(7200), "2 h");
    Check.equal(Text.duration(-3 * 86400), "-3 d");
    Check.equal(Text.duration(Double.NaN), "nan s");
    Check.equal(Text.age(Long.MIN_VALUE, Long.MAX_VALUE), "213503982 d");
  }

  static void testStringsStayOneLine() {
    Check.equal(Text.line("a\nb\u0000c\u001b[2J"), "a b c [2J");
    Check.equal(Text.line("x".repeat(100_000)).length(), 201);
    Check.equal(Text.line(null), "");
  }

  static void testArrivalsCountGapsAndNotRestarts() {
    Arrivals arrivals = new Arrivals();
    Check.equal(arrivals.describe(0), "no message yet");
    for (long seq : new long[] {5, 6, 9, 0, 1}) {
      arrivals.add(seq * SECOND_NS / 10, seq);
    }
    Check.equal(arrivals.lost(), 2L);
    Arrivals steady = new Arrivals();
    for (int i = 0; i < 5000; i++) {
      steady.add(i * SECOND_NS / 20, -1);
    }
    long last = 4999 * SECOND_NS / 20;
    Check.equal(steady.describe(last), "5000 messages, 20.0 Hz, the last one came 0.0 s ago");
    Check.equal(steady.describe(last + SECOND_NS),
        "5000 messages, 10.3 Hz, the last one came 1.0 s ago");
    Check.equal(steady.describe(last + 60 * SECOND_NS),
        "5000 messages, the last one came 60.0 s ago");
  }

  static void testTheChosenViewIsFirstAndNanIsLast() {
    next_view_t message = new next_view_t();
    double[] gains = {1, Double.NaN, 3, 2, Double.POSITIVE_INFINITY};
    message.candidates = new view_candidate_t[gains.length];
    for (int i = 0; i < gains.length; i++) {
      message.candidates[i] = new view_candidate_t();
      message.candidates[i].gain = gains[i];
    }
    message.num_candidates = gains.length;
    message.selected = 3;
    Rows rows = CandidateRows.of(message, 0).get(0);
    Check.equal(rows.rows().get(0).cells()[0], "3");
    Check.equal(rows.rows().get(1).cells()[0], "4");
    Check.equal(rows.rows().get(4).cells()[0], "1");
    for (int none : new int[] {-1, 5, Integer.MAX_VALUE, Integer.MIN_VALUE}) {
      message.selected = none;
      Check.that(CandidateRows.of(message, 0).get(0).title().contains("no view"), "" + none);
    }
  }

  static void testWhatIsWrongWithAProcessIsMarked() {
    process_status_t status = new process_status_t();
    status.name = "ppf";
    status.state = "ok";
    status.channels = new channel_status_t[] {new channel_status_t()};
    status.stages = new stage_status_t[0];
    Check.equal(ProcessRows.of(List.of(status), 0).get(0).rows().get(0).alarm(), false);
    Check.equal(ProcessRows.of(List.of(status), 4_000_000).get(0).rows().get(0).alarm(), true);
    Check.equal(ProcessRows.of(List.of(status), 0).get(1).rows().get(0).alarm(), false);
    status.channels[0].num_lost = 1;
    Check.equal(ProcessRows.of(List.of(status), 0).get(1).rows().get(0).alarm(), true);
    status.state = "no camera";
    Check.equal(ProcessRows.of(List.of(status), 0).get(0).rows().get(0).alarm(), true);
  }

  static void testRowsAreBounded() {
    Rows rows = new Rows("many", "a");
    for (int i = 0; i < 100_000; i++) {
      rows.add(false, "x");
    }
    Check.equal(rows.rows().size(), Rows.MAX_ROWS);
  }
}
