package vantage.spy;

import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.Dimension;
import java.awt.event.WindowAdapter;
import java.awt.event.WindowEvent;
import java.util.ArrayDeque;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.Executor;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.ThreadFactory;
import java.util.concurrent.ThreadPoolExecutor;
import java.util.concurrent.TimeUnit;
import java.util.function.Function;
import javax.swing.BorderFactory;
import javax.swing.JFrame;
import javax.swing.JLabel;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;
import javax.swing.Timer;
import lcm.spy.ChannelData;

/**
 * A view of one channel with a line about how its messages come. A tap on LCM's thread queues
 * messages, a thread of the window works them out, the Swing thread shows them. A message that
 * cannot be shown is counted and told in the line; the one before stays in sight.
 */
final class MessageWindow {
  private static final int REFRESH_MS = 500;
  private static final int MAX_TASKS = 8;
  private static final Color PLAIN = new Color(60, 64, 72);
  private static final Color ALARM = new Color(190, 30, 30);

  private final JFrame frame;
  private final ExecutorService worker;
  private final MessageView view;
  private final MessageTap tap;
  private final Timer timer = new Timer(REFRESH_MS, event -> refresh());
  private final JLabel status = new JLabel();
  private final Arrivals arrivals = new Arrivals();
  private final ArrayDeque<Object> waiting = new ArrayDeque<>();
  private long numRefused; // Of the Swing thread.
  private String refusal = "";

  /** Fills the empty frame that lcm-spy has made. On the Swing thread. */
  MessageWindow(
      JFrame frame, ChannelData channel, String title, Function<Executor, MessageView> makeView) {
    this.frame = frame;
    worker = newWorker(channel.name);
    view = makeView.apply(worker);

    status.putClientProperty("html.disable", Boolean.TRUE);
    status.setName("status");
    status.setBorder(BorderFactory.createEmptyBorder(4, 8, 4, 8));
    JPanel content = new JPanel(new BorderLayout());
    content.add(view.component(), BorderLayout.CENTER);
    content.add(status, BorderLayout.SOUTH);
    frame.setContentPane(content);
    frame.setTitle(Text.line(channel.name) + ": " + title);
    Dimension size = content.getPreferredSize();
    frame.setSize(size.width + 20, size.height + 40);
    frame.setDefaultCloseOperation(JFrame.DISPOSE_ON_CLOSE);
    frame.validate();

    tap = new MessageTap(channel, this::queue);
    if (channel.last != null) {
      queue(channel.last);
    }
    frame.addWindowListener(new WindowAdapter() {
      @Override
      public void windowClosed(WindowEvent event) {
        timer.stop();
        tap.close();
        worker.shutdown();
      }
    });
    refresh();
    timer.start();
  }

  // Its queue is bounded; what is left out matters not, because every task does all there is to do.
  private static ExecutorService newWorker(String name) {
    ThreadFactory makeThread = task -> {
      Thread thread = new Thread(task, "spy window " + name);
      thread.setDaemon(true);
      return thread;
    };
    return new ThreadPoolExecutor(
        1,
        1,
        0,
        TimeUnit.SECONDS,
        new ArrayBlockingQueue<>(MAX_TASKS),
        makeThread,
        new ThreadPoolExecutor.DiscardOldestPolicy());
  }

  // On LCM's thread.
  private void queue(Object message) {
    arrivals.add(System.nanoTime(), view.seq(message));
    synchronized (waiting) {
      while (waiting.size() >= view.queueLength()) {
        waiting.removeFirst();
      }
      waiting.addLast(message);
    }
    worker.execute(this::showWaiting);
  }

  private Object takeWaiting() {
    synchronized (waiting) {
      return waiting.pollFirst();
    }
  }

  private void showWaiting() {
    for (Object message = takeWaiting(); message != null; message = takeWaiting()) {
      show(message);
    }
  }

  private void show(Object message) {
    try {
      Runnable shown = view.prepare(message);
      SwingUtilities.invokeLater(() -> {
        refusal = "";
        shown.run();
      });
    } catch (RuntimeException | OutOfMemoryError problem) {
      String sentence = problem instanceof IllegalArgumentException
          ? Text.line(problem.getMessage()) : Text.line(problem.toString());
      SwingUtilities.invokeLater(() -> {
        numRefused++;
        refusal = sentence;
        refresh();
      });
    }
  }

  private void refresh() {
    tap.install();
    view.refresh(1000 * System.currentTimeMillis());
    String text = arrivals.describe(System.nanoTime());
    if (numRefused > 0) {
      text += "; " + numRefused + " could not be shown";
    }
    status.setForeground(refusal.isEmpty() ? PLAIN : ALARM);
    status.setText(refusal.isEmpty() ? text : "not shown: " + refusal + " (" + text + ")");
  }
}
