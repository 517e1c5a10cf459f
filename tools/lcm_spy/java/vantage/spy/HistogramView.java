package vantage.spy;

import java.awt.BorderLayout;
import java.awt.FlowLayout;
import java.awt.event.ComponentAdapter;
import java.awt.event.ComponentEvent;
import java.awt.event.MouseAdapter;
import java.awt.event.MouseEvent;
import java.awt.image.BufferedImage;
import java.util.Map;
import java.util.HashMap;
import java.util.concurrent.Executor;
import javax.swing.JComboBox;
import javax.swing.JComponent;
import javax.swing.JLabel;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;
import vantage.orientation_histogram_t;

/**
 * The orientation histogram of one object: where its orientations take a vector, on both sides of a
 * sphere. Object and vector are chosen, dragging turns the sphere.
 */
final class HistogramView implements MessageView {
  private static final int MAX_OBJECTS = 64;
  private static final double TURN = 0.008; // rad by px
  private static final double MAX_ELEVATION = 1.5; // rad

  private final Executor worker;
  private final JPanel panel = new JPanel(new BorderLayout());
  private final JComboBox<String> objects = new JComboBox<>();
  private final JComboBox<RotatedVector> vectors = new JComboBox<>(RotatedVector.values());
  private final JLabel line = new JLabel(" ");
  private final SphereCanvas canvas = new SphereCanvas();
  private final Map<String, orientation_histogram_t> latest = new HashMap<>(); // Swing thread's.
  private double azimuth = Math.toRadians(45);
  private double elevation = Math.asin(Math.sqrt(1 / 3.0));

  HistogramView(Executor worker) {
    this.worker = worker;
    objects.setName("objects");
    vectors.setName("vectors");
    canvas.setName("spheres");
    line.setName("histogram line");
    line.putClientProperty("html.disable", Boolean.TRUE);
    JPanel choices = new JPanel(new FlowLayout(FlowLayout.LEFT));
    choices.add(new JLabel("Object"));
    choices.add(objects);
    choices.add(new JLabel("Rotated vector"));
    choices.add(vectors);
    choices.add(line);
    panel.add(choices, BorderLayout.NORTH);
    panel.add(canvas, BorderLayout.CENTER);
    objects.addActionListener(event -> draw());
    vectors.addActionListener(event -> draw());
    canvas.addComponentListener(new ComponentAdapter() {
      @Override
      public void componentResized(ComponentEvent event) {
        draw();
      }
    });
    MouseAdapter turn = new Turn();
    canvas.addMouseListener(turn);
    canvas.addMouseMotionListener(turn);
  }

  @Override
  public JComponent component() {
    return panel;
  }

  @Override
  public int queueLength() {
    return MAX_OBJECTS; // One message an object, in a burst.
  }

  @Override
  public long seq(Object message) {
    return ((orientation_histogram_t) message).seq;
  }

  @Override
  public Runnable prepare(Object message) {
    orientation_histogram_t histogram = (orientation_histogram_t) message;
    SphereSamples.checkGrid(histogram);
    return () -> keep(histogram);
  }

  private void keep(orientation_histogram_t histogram) {
    String name = histogram.instance_id + ": " + Text.line(histogram.model_id);
    if (!latest.containsKey(name)) {
      if (latest.size() == MAX_OBJECTS) {
        return;
      }
      int place = 0;
      while (place < objects.getItemCount() && objects.getItemAt(place).compareTo(name) < 0) {
        place++;
      }
      objects.insertItemAt(name, place);
      if (latest.isEmpty()) {
        objects.setSelectedIndex(0);
      }
    }
    latest.put(name, histogram);
    if (name.equals(objects.getSelectedItem())) {
      draw();
    }
  }

  // Leaves the work to the window's thread. On the Swing thread.
  private void draw() {
    orientation_histogram_t histogram = latest.get(objects.getSelectedItem());
    if (histogram == null) {
      return;
    }
    RotatedVector vector = (RotatedVector) vectors.getSelectedItem();
    int width = (canvas.getWidth() - 3 * SpherePicture.MARGIN - 2) / 4;
    int height = (canvas.getHeight() - 2 * SpherePicture.MARGIN - 1) / 2;
    int radius = Math.max(20, Math.min(400, Math.min(width, height)));
    double[] towards = {
      Math.cos(elevation) * Math.cos(azimuth),
      Math.cos(elevation) * Math.sin(azimuth),
      Math.sin(elevation)
    };
    worker.execute(() -> {
      SphereSamples samples = SphereSamples.of(histogram, vector.direction());
      BufferedImage image = SpherePicture.of(samples, towards, radius);
      SwingUtilities.invokeLater(() -> {
        canvas.show(image);
        line.setText(describe(histogram, samples));
      });
    });
  }

  static String describe(orientation_histogram_t histogram, SphereSamples samples) {
    String text = histogram.num_cells + " cells of k = " + histogram.k;
    if (samples.peak() != null) {
      text += ", the heaviest has " + Text.number(100 * samples.peakShare(), 2)
          + " % at w x y z = " + Text.numbers(samples.peak(), 3);
    }
    if (samples.numIgnored() > 0) {
      text += "; " + samples.numIgnored() + " ignored: none of the grid, or no sound weight";
    }
    return text;
  }

  private final class Turn extends MouseAdapter {
    private int lastX;
    private int lastY;

    @Override
    public void mousePressed(MouseEvent event) {
      lastX = event.getX();
      lastY = event.getY();
    }

    @Override
    public void mouseDragged(MouseEvent event) {
      azimuth -= TURN * (event.getX() - lastX);
      double raised = elevation + TURN * (event.getY() - lastY);
      elevation = Math.max(-MAX_ELEVATION, Math.min(MAX_ELEVATION, raised));
      mousePressed(event);
      draw();
    }
  }
}
