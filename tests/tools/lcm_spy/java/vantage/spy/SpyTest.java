package vantage.spy;

import java.awt.Color;
import java.awt.Component;
import java.awt.image.BufferedImage;
import java.io.PrintStream;
import java.lang.instrument.Instrumentation;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.Properties;
import javax.swing.JComboBox;
import javax.swing.JComponent;
import javax.swing.JFrame;
import javax.swing.JTable;

/**
 * Runs inside lcm-spy's process as a Java agent: opens every window and looks at what is in it.
 * Ends the process with 0 when all is as it must be. The argument is the file of facts that
 * spy_messages wrote.
 */
public final class SpyTest {
  private static final int INVALID = Colors.NO_DEPTH;

  private SpyTest() {}

  /** As Java wants it of an agent. */
  public static void premain(String facts, Instrumentation instrumentation) {
    PrintStream out = System.out;
    Thread thread = new Thread(() -> {
      int code = 1;
      try {
        Properties properties = new Properties();
        properties.load(Files.newBufferedReader(Path.of(facts)));
        run(properties, out);
        code = 0;
      } catch (Exception | AssertionError problem) {
        problem.printStackTrace(out);
      }
      out.println(code == 0 ? "spy test: passed" : "spy test: FAILED");
      out.flush();
      Runtime.getRuntime().halt(code);
    });
    thread.setDaemon(true);
    thread.start();
  }

  private static void run(Properties facts, PrintStream out) throws Exception {
    SpyDriver.waitUntil("lcm-spy has a window", () -> SpyDriver.frame("LCM Spy") != null);
    testEveryTypeIsDecoded(facts);
    out.println("every type decoded");
    testDepth("CAMERA_TEST");
    testDepth("CAMERA_ZLIB");
    testColor("CAMERA_TEST", 1);
    testColor("CAMERA_JPEG", 0);
    out.println("images shown");
    testHistogram(facts, "7: mug", "q.mug");
    testHistogram(facts, "8: filter", "q.filter");
    testHostileHistogram();
    out.println("histograms shown");
    testObjects();
    testDetections();
    testNextView();
    testProcesses();
    out.println("lists shown");
    testHostileImages();
    testRandomMessages();
    testStructureViewerBesidePlugin();
    SpyDriver.screenshot(SpyDriver.onSwing(() -> SpyDriver.frame("LCM Spy")), "spy");
    out.println("hostile messages survived");
  }

  private static JFrame openWindow(String channel, String plugin) throws Exception {
    SpyDriver.waitUntil("a message on " + channel, () -> {
      JTable list = SpyDriver.table(SpyDriver.frame("LCM Spy"), 0);
      return SpyDriver.row(list, channel) != null;
    });
    SpyDriver.onSwing(() -> {
      SpyDriver.open(channel);
      return null;
    });
    SpyDriver.waitUntil(
        channel + " has a window", () -> SpyDriver.frame(channel + ": " + plugin) != null);
    return SpyDriver.onSwing(() -> SpyDriver.frame(channel + ": " + plugin));
  }

  private static void testEveryTypeIsDecoded(Properties facts) throws Exception {
    int numTypes = Integer.parseInt(facts.getProperty("types"));
    SpyDriver.waitUntil("every type is decoded under its name", () -> {
      JTable list = SpyDriver.table(SpyDriver.frame("LCM Spy"), 0);
      int decoded = 0;
      for (int r = 0; r < list.getRowCount(); r++) {
        String channel = String.valueOf(list.getValueAt(r, 0)).trim();
        String type = String.valueOf(list.getValueAt(r, 1)).trim();
        boolean sound = "0".equals(String.valueOf(list.getValueAt(r, 7)).trim());
        decoded += channel.equals("TYPE_" + type) && sound ? 1 : 0;
      }
      return decoded == numTypes;
    });
    SpyDriver.waitUntil("a foreign type is told as unknown", () -> {
      String[] row =
          SpyDriver.row(SpyDriver.table(SpyDriver.frame("LCM Spy"), 0), "SOMEONE_ELSES");
      return row != null && row[1].startsWith("??");
    });
  }

  private static double share(BufferedImage image, java.util.function.IntPredicate counts) {
    int[] rgb = image.getRGB(0, 0, image.getWidth(), image.getHeight(), null, 0, image.getWidth());
    return Arrays.stream(rgb).map(c -> c & 0xffffff).filter(counts).count() / (double) rgb.length;
  }

  private static BufferedImage picture(JFrame frame, int index, String file) throws Exception {
    SpyDriver.waitUntil("a picture in " + frame.getTitle(), () -> {
      var parts = SpyDriver.parts(frame, JComponent.class, p -> "picture".equals(p.getName()));
      return parts.size() > index && parts.get(index).getWidth() > 0
          && SpyDriver.text(frame, "picture line").contains("px");
    });
    Component part = SpyDriver.onSwing(() ->
        SpyDriver.parts(frame, JComponent.class, p -> "picture".equals(p.getName())).get(index));
    return SpyDriver.screenshot(part, file);
  }

  // Three fifths of 320 x 240 px are measured, 600 to 1396 mm; the picture has dark sides.
  private static void testDepth(String channel) throws Exception {
    JFrame frame = openWindow(channel, "Images");
    SpyDriver.eventually(() -> {
      checkDepth(frame, picture(frame, 0, channel));
      return null;
    });
    SpyDriver.waitUntil("the window counts", () -> {
      String status = SpyDriver.text(frame, "status");
      return status.contains("Hz") && status.contains(" lost") && !status.contains("not shown");
    });
    if (channel.equals("CAMERA_ZLIB")) {
      close(frame);
    }
  }

  private static void checkDepth(JFrame frame, BufferedImage image) throws Exception {
    String line = SpyDriver.onSwing(() -> SpyDriver.text(frame, "picture line"));
    check(line.contains("320 x 240 px, 60.0 % measured, 600 to 1396 mm"), line);
    // The color scale beside the picture and what is around it are left out.
    int scale = 66;
    double factor = Math.min((image.getWidth() - scale) / 320.0, image.getHeight() / 240.0);
    int width = (int) (factor * 320);
    int height = (int) (factor * 240);
    int left = (int) (image.getWidth() - scale - factor * 320) / 2;
    int top = (int) (image.getHeight() - factor * 240) / 2;
    BufferedImage inside = image.getSubimage(left, top, width, height);
    double invalid = share(inside, c -> c == INVALID);
    check(Math.abs(invalid - 0.4) < 0.02, "a share of " + invalid + " is dark, expected 0.4");
    double near = lightness(inside.getRGB(width / 2, height / 20));
    double far = lightness(inside.getRGB(width / 2, height - height / 20));
    check(near > far + 100, "near has lightness " + near + ", far " + far);
  }

  private static void testColor(String channel, int index) throws Exception {
    JFrame frame = index == 1
        ? SpyDriver.onSwing(() -> SpyDriver.frame(channel)) : openWindow(channel, "Images");
    SpyDriver.eventually(() -> {
      BufferedImage image = picture(frame, index, channel + "_color");
      double red = share(image, c -> (c >> 16) > 180 && (c >> 8 & 0xff) < 40);
      double green = share(image, c -> (c >> 16) < 40 && (c >> 8 & 0xff) > 160);
      check(red > 0.15 && Math.abs(red - green) < 0.05, red + " is red, " + green + " is green");
      return null;
    });
    close(frame);
  }

  // A dark spot where the peak's orientation takes (1, 1, 1), on one side and not on the other.
  private static void testHistogram(Properties facts, String object, String key) throws Exception {
    double[] q = Arrays.stream(facts.getProperty(key).split(" "))
        .mapToDouble(Double::parseDouble).toArray();
    JFrame frame = openWindow("ORIENTATION_HISTOGRAM", "Orientation histogram");
    SpyDriver.waitUntil("both objects came, though in a burst",
        () -> SpyDriver.named(frame, JComboBox.class, "objects").getItemCount() == 2);
    for (String vector : new String[] {"(1, 1, 1)/√3", "x axis", "y axis", "z axis"}) {
      SpyDriver.onSwing(() -> {
        SpyDriver.choose(SpyDriver.named(frame, JComboBox.class, "objects"), object);
        SpyDriver.choose(SpyDriver.named(frame, JComboBox.class, "vectors"), vector);
        return null;
      });
      JComponent spheres =
          SpyDriver.onSwing(() -> SpyDriver.named(frame, JComponent.class, "spheres"));
      String file = "histogram_" + object.substring(0, 1) + "_" + vector.charAt(0);
      SpyDriver.eventually(() -> {
        BufferedImage image = SpyDriver.screenshot(spheres, file);
        checkSpot(image, Vectors.rotate(q, direction(vector)));
        return null;
      });
    }
    close(frame);
  }

  private static double[] direction(String vector) {
    return switch (vector.charAt(0)) {
      case 'x' -> new double[] {1, 0, 0};
      case 'y' -> new double[] {0, 1, 0};
      case 'z' -> new double[] {0, 0, 1};
      default -> Vectors.unit(1, 1, 1);
    };
  }

  // Where docs/spy.md says that a direction lies: seen from (1, 1, 1), z up, near side left.
  private static void checkSpot(BufferedImage image, double[] direction) {
    int radius = Math.min((image.getWidth() - 32) / 4, (image.getHeight() - 21) / 2);
    double across = (direction[1] - direction[0]) / Math.sqrt(2);
    double up = (2 * direction[2] - direction[0] - direction[1]) / Math.sqrt(6);
    double towards = (direction[0] + direction[1] + direction[2]) / Math.sqrt(3);
    boolean near = towards > 0;
    int middle = image.getWidth() / 2 + (near ? -1 : 1) * (radius + 5);
    int u = (int) Math.round(middle + radius * (near ? across : -across));
    int v = (int) Math.round(image.getHeight() / 2.0 - radius * up);
    long[] sum = new long[3];
    int dark = 0;
    for (int y = 0; y < image.getHeight(); y++) {
      for (int x = 0; x < image.getWidth(); x++) {
        Color color = new Color(image.getRGB(x, y));
        if (color.getBlue() > 60 && color.getRed() < 70 && color.getGreen() < 120
            && color.getBlue() > color.getGreen() + 30) {
          dark++;
          sum[0] += x;
          sum[1] += y;
        }
      }
    }
    // The blue axis' end is dark too; where the spot is on a rim both sides have some of it.
    check(dark > 40, "only " + dark + " dark pixels");
    check(dark < 0.1 * image.getWidth() * image.getHeight(), dark + " dark pixels");
    int found = 0;
    for (int y = Math.max(0, v - 4); y <= Math.min(image.getHeight() - 1, v + 4); y++) {
      for (int x = Math.max(0, u - 4); x <= Math.min(image.getWidth() - 1, u + 4); x++) {
        found += lightness(image.getRGB(x, y)) < 330 ? 1 : 0;
      }
    }
    check(found > 25, "at (" + u + ", " + v + "), where the peak is, " + found + " of 81 dark");
  }

  private static void testHostileHistogram() throws Exception {
    JFrame frame = openWindow("HISTOGRAM_HOSTILE", "Orientation histogram");
    SpyDriver.waitUntil("what is none of the grid is counted",
        () -> SpyDriver.text(frame, "histogram line").contains("5 ignored"));
    close(frame);
  }

  private static void checkRow(
      String channel, String plugin, int table, String[] begin, String... cells) throws Exception {
    JFrame frame = openWindow(channel, plugin);
    String wanted = Arrays.toString(begin) + " with " + Arrays.toString(cells);
    SpyDriver.waitUntil("a line " + wanted, () -> {
      JTable list = SpyDriver.table(frame, table);
      String[] row = list == null ? null : SpyDriver.row(list, begin);
      return row != null && Arrays.asList(row).containsAll(Arrays.asList(cells));
    });
    if (table == 0) {
      SpyDriver.eventually(() -> {
        BufferedImage image = SpyDriver.screenshot(frame, channel);
        double ink = share(image, c -> lightness(c) < 300);
        check(ink > 0.003, "an ink share of " + ink + " in " + channel);
        return null;
      });
    }
    close(frame);
  }

  private static void testObjects() throws Exception {
    String[] mug = {"7", "mug", "confirmed", "5"};
    checkRow("OBJECTS", "Objects", 0, mug, "0.300", "2.00", "refinement of 0 images");
    checkRow("OBJECTS", "Objects", 0, new String[] {"9", "<html><b>bold", "lost"}, "0.300");
    checkRow("OBJECTS", "Objects", 1, new String[] {"8: filter", "1", "0.750"}, "2.00");
  }

  private static void testDetections() throws Exception {
    checkRow("DETECTIONS_TEST", "Detections", 0, new String[] {"0", "bracket", "0.875"},
        "2.00", "0.0000 0.0000 0.7500");
  }

  private static void testNextView() throws Exception {
    checkRow("NEXT_VIEW", "Next view", 0, new String[] {"2", "chosen", "1.0000"}, "yes");
    checkRow("NEXT_VIEW", "Next view", 0, new String[] {"3", "", "1.5000"}, "no", "too far");
    checkRow("NEXT_VIEW", "Next view", 0, new String[] {"4", "", "nan"}, "yes");
  }

  private static void testProcesses() throws Exception {
    checkRow("PROCESS_STATUS", "Processes", 0, new String[] {"ppf", "here"}, "ok");
    checkRow("PROCESS_STATUS", "Processes", 0, new String[] {"fusion", "here"}, "no camera");
    checkRow("PROCESS_STATUS", "Processes", 1, new String[] {"ppf", "CAMERA_TEST"}, "3");
    checkRow("PROCESS_STATUS", "Processes", 2, new String[] {"fusion", "match"}, "125.00");
  }

  // The sound image stays in sight, the others are told.
  private static void testHostileImages() throws Exception {
    JFrame frame = openWindow("CAMERA_HOSTILE", "Images");
    SpyDriver.waitUntil("what is wrong is told", () -> {
      String status = SpyDriver.text(frame, "status");
      return status.contains("could not be shown")
          && SpyDriver.text(frame, "picture line").contains("600 to 1396 mm");
    });
    JTable list = SpyDriver.onSwing(() -> SpyDriver.table(SpyDriver.frame("LCM Spy"), 0));
    SpyDriver.waitUntil("undecodable ones are counted",
        () -> Integer.parseInt(SpyDriver.row(list, "CAMERA_HOSTILE")[7]) >= 3);
    close(frame);
  }

  // Any bits in any field: windows open, live on, and say what they cannot show.
  private static void testRandomMessages() throws Exception {
    String[][] windows = {
      {"TYPE_images_t", "Images"},
      {"TYPE_orientation_histogram_t", "Orientation histogram"},
      {"TYPE_object_estimates_v3_t", "Objects"},
      {"TYPE_detections_v2_t", "Detections"},
      {"TYPE_next_view_t", "Next view"},
      {"TYPE_process_status_t", "Processes"}
    };
    for (String[] window : windows) {
      JFrame frame = openWindow(window[0], window[1]);
      SpyDriver.waitUntil(window[0] + " goes on", () -> {
        String status = SpyDriver.text(frame, "status");
        return status.matches(".*\\b[3-9] messages.*");
      });
      close(frame);
    }
  }

  // lcm-spy's own viewer and a plugin's window live side by side on a channel.
  private static void testStructureViewerBesidePlugin() throws Exception {
    JFrame window = openWindow("OBJECTS", "Objects");
    SpyDriver.onSwing(() -> {
      SpyDriver.chooseFromMenu("OBJECTS", "Structure Viewer...");
      return null;
    });
    SpyDriver.waitUntil("the structure viewer opens", () -> viewer() != null);
    SpyDriver.waitUntil("the window goes on beside it", () ->
        SpyDriver.text(window, "status").matches("[4-9] messages.*"));
    SpyDriver.screenshot(SpyDriver.onSwing(SpyTest::viewer), "structure");
    close(window);
  }

  private static JFrame viewer() {
    return SpyDriver.frame(title -> title.equals("OBJECTS"));
  }

  private static void close(JFrame frame) throws Exception {
    SpyDriver.onSwing(() -> {
      frame.dispose();
      return null;
    });
  }

  private static int lightness(int rgb) {
    return (rgb >> 16 & 0xff) + (rgb >> 8 & 0xff) + (rgb & 0xff);
  }

  private static void check(boolean holds, String otherwise) {
    if (!holds) {
      throw new AssertionError(otherwise);
    }
  }
}
