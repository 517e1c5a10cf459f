package vantage.spy;

import java.util.ArrayDeque;

/** Rate and losses of a channel, by when its messages came and by their seq. */
final class Arrivals {
  private static final long WINDOW_NS = 2_000_000_000L;
  private static final int MAX_TIMES = 1000;

  private final ArrayDeque<Long> times = new ArrayDeque<>();
  private long count;
  private long lost;
  private long lastSeq = -1;
  private long lastNs;

  /** A seq below 0 says nothing; one that does not grow is a sender that began anew. */
  synchronized void add(long nowNs, long seq) {
    count++;
    if (seq >= 0 && lastSeq >= 0 && seq > lastSeq) {
      lost += seq - lastSeq - 1;
    }
    lastSeq = seq;
    lastNs = nowNs;
    times.addLast(nowNs);
    if (times.size() > MAX_TIMES) {
      times.removeFirst();
    }
  }

  /** One line about them. */
  synchronized String describe(long nowNs) {
    if (count == 0) {
      return "no message yet";
    }
    while (times.size() > 1 && nowNs - times.peekFirst() > WINDOW_NS) {
      times.removeFirst();
    }
    String rate = times.size() > 1 ? Text.number(rate(nowNs), 1) + " Hz, " : "";
    String losses = lastSeq < 0 ? "" : "seq " + lastSeq + ", " + lost + " lost, ";
    return count + (count == 1 ? " message, " : " messages, ") + rate + losses
        + "the last one came " + Text.duration(1e-9 * (nowNs - lastNs)) + " ago";
  }

  // Hz; falls as soon as the next message is later than the others were.
  private double rate(long nowNs) {
    int intervals = times.size() - 1;
    double span = 1e-9 * Math.max(1, times.peekLast() - times.peekFirst());
    double sinceFirst = 1e-9 * (nowNs - times.peekFirst());
    return intervals / Math.max(span, sinceFirst - span / intervals);
  }

  synchronized long lost() {
    return lost;
  }
}
