package vantage.spy;

import java.io.EOFException;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.concurrent.Executor;
import lcm.lcm.LCMDataInputStream;
import lcm.logging.Log;
import vantage.detections_v2_t;
import vantage.images_t;
import vantage.next_view_t;
import vantage.object_estimates_v3_t;
import vantage.orientation_histogram_t;
import vantage.process_status_t;

/**
 * Messages of a log with flipped bits, as far as they can be decoded: the windows show them or
 * refuse them with a sentence. The argument is the log of spy_messages.
 */
public final class HostileTest {
  private static final int DAMAGES = 20; // Of each message.
  private static final int MESSAGES = 4; // Of each channel.

  private static String log;

  private HostileTest() {}

  public static void main(String[] arguments) throws IllegalAccessException {
    log = arguments[0];
    Check.runAll(HostileTest.class);
  }

  static void testFlippedBits() throws Exception {
    Executor now = Runnable::run;
    Map<Class<?>, MessageView> views = new HashMap<>();
    views.put(images_t.class, new PicturesView(now));
    views.put(orientation_histogram_t.class, new HistogramView(now));
    views.put(process_status_t.class, new ProcessView(now));
    views.put(
        object_estimates_v3_t.class,
        new ListView<>(
            object_estimates_v3_t.class, m -> m.seq, ObjectRows::of, new TablesPanel(9, 9, 9)));
    views.put(
        detections_v2_t.class,
        new ListView<>(
            detections_v2_t.class, m -> m.seq, DetectionRows::of, new TablesPanel(9, 9)));
    views.put(
        next_view_t.class,
        new ListView<>(next_view_t.class, m -> -1, CandidateRows::of, new TablesPanel(9, 9)));
    Random random = new Random(1);
    for (Map.Entry<Class<?>, MessageView> entry : views.entrySet()) {
      Class<?> type = entry.getKey();
      int shown = 0;
      int refused = 0;
      int undecodable = 0;
      for (byte[] sound : messages(type)) {
        for (int i = 0; i < DAMAGES; i++) {
          byte[] damaged = i == 0 ? sound : flipped(sound, random);
          Object message = decode(type, damaged);
          if (message == null) {
            undecodable++;
            continue;
          }
          entry.getValue().seq(message);
          try {
            entry.getValue().prepare(message).run();
            entry.getValue().refresh(0);
            shown++;
          } catch (IllegalArgumentException sentence) {
            refused++;
          }
        }
      }
      System.out.println(type.getName() + ": " + shown + " shown, " + refused + " refused, "
          + undecodable + " not decoded");
      Check.that(shown > 0, "no message of " + type + " was shown");
    }
  }

  private static byte[] flipped(byte[] sound, Random random) {
    byte[] damaged = sound.clone();
    int flips = 1 + random.nextInt(4);
    for (int i = 0; i < flips; i++) {
      // Half of them near the beginning, where the sizes are.
      int span = random.nextBoolean() ? Math.min(200, damaged.length) : damaged.length;
      damaged[8 + random.nextInt(span - 8)] ^= (byte) (1 << random.nextInt(8));
    }
    return damaged;
  }

  // As lcm-spy does; null where the generated decoder throws.
  private static Object decode(Class<?> type, byte[] bytes) throws Exception {
    try {
      return type.getConstructor(java.io.DataInput.class)
          .newInstance(new LCMDataInputStream(bytes));
    } catch (java.lang.reflect.InvocationTargetException problem) {
      return null;
    }
  }

  private static List<byte[]> messages(Class<?> type) throws Exception {
    long fingerprint = type.getField("LCM_FINGERPRINT").getLong(null);
    Map<String, Integer> taken = new HashMap<>();
    List<byte[]> found = new ArrayList<>();
    Log events = new Log(log, "r");
    try {
      while (true) {
        Log.Event event = events.readNext();
        boolean ours = event.data.length > 8
            && new LCMDataInputStream(event.data).readLong() == fingerprint;
        if (ours && taken.merge(event.channel, 1, Integer::sum) <= MESSAGES) {
          found.add(event.data);
        }
      }
    } catch (EOFException end) {
      return found;
    } finally {
      events.close();
    }
  }
}
