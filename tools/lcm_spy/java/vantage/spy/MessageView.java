package vantage.spy;

import javax.swing.JComponent;

/** What a window shows of the messages of one channel. */
interface MessageView {
  /** On the Swing thread. */
  JComponent component();

  /**
   * Works a message out, on the window's own thread. What it returns runs on the Swing thread.
   * Throws an IllegalArgumentException with one sentence when the message makes no sense.
   */
  Runnable prepare(Object message);

  /** Twice a second on the Swing thread, for what changes without messages: ages. */
  default void refresh(long nowUtime) {}

  /** By which lost messages are seen; -1 when messages of this type have none. On any thread. */
  default long seq(Object message) {
    return -1;
  }

  /** Messages that may wait to be shown; of more the oldest go. */
  default int queueLength() {
    return 1;
  }
}
