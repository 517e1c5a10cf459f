package vantage.spy;

import java.util.function.Consumer;
import javax.swing.JFrame;
import lcm.spy.ChannelData;
import lcm.spy.ChartData;
import lcm.spy.ObjectPanel;

/**
 * Hands over every message that lcm-spy decodes on a channel, on LCM's thread. ChannelData.last
 * alone would not do: who looks at it now and then misses messages that come in a burst. lcm-spy
 * gives each one to ChannelData.viewer, its structure viewer; the tap stands in front of that.
 */
final class MessageTap extends ObjectPanel {
  private static final long serialVersionUID = 1;
  private final transient ChannelData channel;
  private final transient Consumer<Object> consumer;
  private transient volatile ObjectPanel next;
  private volatile boolean closed;

  MessageTap(ChannelData channel, Consumer<Object> consumer) {
    super(channel.name, new ChartData(0));
    this.channel = channel;
    this.consumer = consumer;
    install();
  }

  /** Stands in front again after lcm-spy has opened a structure viewer. On the Swing thread. */
  void install() {
    if (isInstalled()) {
      return;
    }
    if (channel.viewerFrame == null) {
      // With a viewer lcm-spy expects its frame; it replaces both when this one is not visible.
      channel.viewerFrame = new JFrame(channel.name);
    }
    next = channel.viewer;
    channel.viewer = this;
  }

  private boolean isInstalled() {
    for (ObjectPanel at = channel.viewer; at instanceof MessageTap tap; at = tap.next) {
      if (tap == this) {
        return true;
      }
    }
    return false;
  }

  /** From now on it only passes on. */
  void close() {
    closed = true;
  }

  @Override
  public void setObject(Object message, long utime) {
    if (!closed) {
      consumer.accept(message);
    }
    ObjectPanel behind = next;
    if (behind != null) {
      behind.setObject(message, utime);
    }
  }
}
